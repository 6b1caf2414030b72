#!/usr/bin/env bash
# Writes the files of this folder from its configs, with the `stickslip` and `python` on the PATH,
# in some two minutes: for a release. They are never written again after it.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp "$here"/*.yaml "$here"/*.csv "$work"
cd "$work"
stickslip sweep followed.yaml -o followed.nc
stickslip sweep stochastic.yaml -o stochastic.nc
stickslip sweep unfinished.yaml --set 'temperature=[200, 225]' -o unfinished.nc
stickslip sweep unfinished.yaml -o unfinished.nc --partial
stickslip simulate unfinished.yaml --set T=200 --set gamma=-2/3 -o trajectory.nc
stickslip sweep borders.yaml -o map.nc
stickslip boundary map.nc -o borders.nc
stickslip fit forces.csv film.yaml --free k -o fit.nc
rm map.nc
gzip -9n ./*.nc
PYTHONPATH="$here/../.." python -m support.public_names > names.txt
cp ./*.nc.gz names.txt "$here"
