// Makes elements of HTML and of SVG; texts stay texts.

const SVG = "http://www.w3.org/2000/svg";

/** Fill an element with attributes and children; a function is a listener, and false or null leaves an attribute out. */
function filled(node, attributes, children) {
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") node.addEventListener(key.slice(2), value);
    else if (value !== null && value !== undefined && value !== false) node.setAttribute(key, value === true ? "" : value);
  }
  node.append(...children);
  return node;
}

/** Make an element of HTML. */
export const make = (name, attributes = {}, ...children) => filled(document.createElement(name), attributes, children);

/** Make an element of SVG. */
export const svg = (name, attributes = {}, ...children) => filled(document.createElementNS(SVG, name), attributes, children);
