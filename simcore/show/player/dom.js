// Functions that make HTML and SVG elements; text is never parsed as HTML.

const SVG = "http://www.w3.org/2000/svg";

/** Add attributes and children to an element. Functions become event listeners; false and null attributes are left out. */
function filled(node, attributes, children) {
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") node.addEventListener(key.slice(2), value);
    else if (value !== null && value !== undefined && value !== false) node.setAttribute(key, value === true ? "" : value);
  }
  node.append(...children);
  return node;
}

/** Make an HTML element. */
export const make = (name, attributes = {}, ...children) => filled(document.createElement(name), attributes, children);

/** Make an SVG element. */
export const svg = (name, attributes = {}, ...children) => filled(document.createElementNS(SVG, name), attributes, children);
