#!/bin/sh
# A sequence that Blender has rendered, as one picture: a row for each frame with
# its ambient occlusion, indirect light and lit picture, free of path tracing's
# noise.
#
#   06_contact_sheet.sh SHEET.png FRAME.exr...
#
# Blender: Cycles, passes Z, Normal, Diffuse Direct and Color, Emission, output
# OpenEXR MultiLayer (32 bits); beside each frame its camera, FRAME.json.
# Needs hbil and oiiotool (on Debian: hbil-tools, openimageio-tools); HBIL and
# OIIOTOOL may name others.
set -eu
if test $# -lt 2; then
  echo "usage: $0 SHEET.png FRAME.exr..." >&2
  exit 2
fi
sheet=$1
shift
work=$(mktemp -d "${TMPDIR:-/tmp}/sheet.XXXXXX")
trap 'rm -rf "$work"' EXIT
trap 'exit 2' HUP INT TERM

# light is carried from frame to frame, so these are frames of one shot
"${HBIL:-hbil}" process --quiet --preview --layers AO,indirect,beauty \
  -o "$work" "$@"
# AO, beauty, indirect: the order of their names
"${OIIOTOOL:-oiiotool}" "$work"/*.png --mosaic:pad=4 "3x$#" -o "$sheet"
