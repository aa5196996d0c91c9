#!/usr/bin/env bash
# Makes three.min.js, the part of three.js that the page uses, and prints its hash for vendor.py. Needs npm and a
# network; run it only to take another release. The same versions give the same bytes.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init --yes >/dev/null
npm install --ignore-scripts --no-audit --no-fund three@0.184.0 esbuild@0.28.2
node node_modules/esbuild/install.js
cp "$here/entry.mjs" .
node_modules/.bin/esbuild entry.mjs --bundle --minify --format=iife --global-name=THREE --target=es2020 \
  --banner:js="/* three.js 0.184.0, MIT licence, https://threejs.org; see three-LICENSE.txt */" --outfile=three.min.js
cp three.min.js "$here/three.min.js"
cp node_modules/three/LICENSE "$here/three-LICENSE.txt"
sha256sum "$here/three.min.js"
