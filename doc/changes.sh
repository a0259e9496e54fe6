#!/bin/sh
# Makes changes.png of FOLDER: what `hbil process` makes of sequences in which things
# move and lights change, beside what a path tracer has.  Each sequence is a folder
# of frame_NNNN.exr, with truth_avg_NNNN.exr beside them, whose layer
# ViewLayer.DiffInd is the reference.  In each of them the first row is hbil's, the
# second one the path tracer's, and the third one the difference, about grey.  Needs
# oiiotool (openimageio-tools) and a font (fonts-dejavu-core).
#
#   changes.sh ./hbil FOLDER SEQUENCE,GAIN,TEXT...
#
# GAIN multiplies the light in its pictures.  In doc/changes.png it is, sequence by
# sequence, 1, 1.6, 1.7, 2, 3.2, 3.4, 1.8 and 1.4.
set -eu
hbil=$1 folder=$2
shift 2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
columns='01 06 08 12'
size=96x54

text() {
  oiiotool --create 384x20 3 --fill:color=1,1,1 384x20 \
    --text:x=4:y=15:size=13:color=0,0,0:font=DejaVuSans.ttf "$1" -o "$2"
}

rows=
number=0
for one in "$@"; do
  number=$((number + 1))
  sequence=${one%%,*}
  one=${one#*,}
  gain=${one%%,*}
  "$hbil" process --quiet --layers indirect -o "$work/$number" "$sequence"/frame_*.exr
  for column in $columns; do
    oiiotool "$work/$number/frame_00$column.exr" \
      --ch indirect.R,indirect.G,indirect.B --mulc "$gain" -o "$work/ours.exr"
    oiiotool "$sequence/truth_avg_00$column.exr" \
      --ch ViewLayer.DiffInd.R,ViewLayer.DiffInd.G,ViewLayer.DiffInd.B \
      --mulc "$gain" -o "$work/truth.exr"
    oiiotool "$work/ours.exr" "$work/truth.exr" --sub --addc .5 --clamp:min=0:max=1 \
      --resize "$size" -d uint8 -o "$work/$number.$column.c.png"
    for row in ours:a truth:b; do
      oiiotool "$work/${row%:*}.exr" --colorconvert linear sRGB --clamp:min=0:max=1 \
        --resize "$size" -d uint8 -o "$work/$number.$column.${row#*:}.png"
    done
  done
  text "${one#*,}" "$work/$number.text.png"
  # shellcheck disable=SC2046
  oiiotool $(for row in a b c; do
    for column in $columns; do echo "$work/$number.$column.$row.png"; done
  done) --mosaic 4x3 -o "$work/$number.rows.png"
  oiiotool "$work/$number.text.png" --create 384x182 3 --paste +0+0 \
    "$work/$number.rows.png" --swap --paste +0+20 -o "$work/$number.png"
  rows="$rows $work/$number.png"
done
# shellcheck disable=SC2086
oiiotool $rows --mosaic:pad=2 "2x$(((number + 1) / 2))" -o "$folder/changes.png"
