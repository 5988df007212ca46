#!/bin/sh
# Make simcore/show/player/vendor/three.min.js again: the parts of three.js that the player uses, as one script.
# It needs node. Usage: scripts/vendor_three.sh [version]
set -eu
version=${1:-0.179.1}
vendor=$(cd "$(dirname "$0")/../simcore/show/player/vendor" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --silent "three@$version" esbuild@0.28.2
names=$(grep -oh 'THREE\.[A-Za-z0-9]*' "$vendor"/../*.js | sort -u | sed 's/THREE\.//' | grep -v OrbitControls | paste -sd, -)
echo "export {$names} from 'three'; export {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';" >entry.js
npx esbuild entry.js --bundle --minify --format=iife --global-name=THREE --legal-comments=none \
    --banner:js="/* three.js $version, MIT license: see LICENSE.three */" --outfile="$vendor/three.min.js"
cp node_modules/three/LICENSE "$vendor/LICENSE.three"
