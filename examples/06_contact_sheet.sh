#!/bin/sh
# A sequence that Blender has rendered, as one picture: a row for each of at most
# eight frames with its indirect light, ambient occlusion and lit picture, free of
# path tracing's noise, and by the temporal filter of the sampling's, too.
#
#   06_contact_sheet.sh SHEET.png FRAME.exr...
#
# Blender: Cycles, passes Z, Normal, Diffuse Direct and Color, Emission, output
# OpenEXR MultiLayer (32 bits); beside each frame its camera, FRAME.json.
# HBIL may name another hbil than that which is installed.
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

# light and filter go from frame to frame, so these are frames of one shot
"${HBIL:-hbil}" process --quiet --max-history-frames 8 --layers ao,indirect,beauty \
  --contact-sheet "$sheet" -o "$work/lit" "$@"
