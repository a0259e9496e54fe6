#!/bin/sh
# Makes one picture of a sequence that Blender has rendered.  It has a row for
# each of at most eight frames, with ambient occlusion, indirect light and the
# lit picture, without the noise of path tracing.
#
#   06_contact_sheet.sh SHEET.png FRAME.exr...
#
# In Blender, render with Cycles and the passes Z, Normal, Diffuse Direct,
# Diffuse Color and Emission to OpenEXR MultiLayer (32 bits).  Beside each frame
# there must be its camera, FRAME.json.  The environment variable HBIL names the
# program if it is not the installed one.
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

# light is carried from frame to frame, so all frames must be of one shot
"${HBIL:-hbil}" process --quiet --slices 8 --layers ao,indirect,beauty \
  --contact-sheet "$sheet" -o "$work/lit" "$@"
