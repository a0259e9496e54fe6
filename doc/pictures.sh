#!/bin/sh
# Makes demo.png and cache.png of this folder by the program's own commands, each
# picture with a line of text below it.  Needs oiiotool (openimageio-tools) and a
# font (fonts-dejavu-core).
#
#   pictures.sh ./hbil FOLDER
set -eu
hbil=$1 folder=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# panel NAME WIDTH HEIGHT TEXT FILE [OPTION...]: options are oiiotool's.
panel() {
  name=$1 width=$2 height=$3 text=$4
  shift 4
  oiiotool "$@" --resize "${width}x$height" -o "$work/panel.png"
  oiiotool --create "${width}x22" 3 --fill:color=1,1,1 "${width}x22" \
    --text:x=4:y=15:size=13:color=0,0,0:font=DejaVuSans.ttf "$text" \
    -o "$work/text.png"
  oiiotool "$work/panel.png" --create "${width}x$((height + 22))" 3 --paste +0+0 \
    "$work/text.png" --swap --paste "+0+$height" -o "$work/$name.png"
}

# The last frame of the demo.
"$hbil" demo -o "$work/demo" >"$work/log"
last=$work/demo/frame_0008
panel a 480 270 'beauty: the finished picture' "$last.beauty.png"
panel b 480 270 'indirect: the indirect light alone' "$last.indirect.png"
panel c 480 270 'ao: ambient occlusion' "$last.ao.png"
panel d 480 270 'bent_normal: the mean open direction' "$last.bent_normal.png"
oiiotool "$work/a.png" "$work/b.png" "$work/c.png" "$work/d.png" \
  --mosaic:pad=4 2x2 -o "$folder/demo.png"

# A lamp behind the camera, with one exposure.  The right third of cache.png stays
# as it is: 400 paths a pixel by a path tracer that isn't part of the project.
"$hbil" demo --scene corner --views --frames 4 --size 480x270 -o "$work/corner" \
  >"$work/log"
"$hbil" process --quiet --far environment -o "$work/alone" \
  "$work"/corner/gbuffer/frame_*.exr
shown='--ch beauty.R,beauty.G,beauty.B --mulc 2.5 --colorconvert linear sRGB -d uint8'
# shellcheck disable=SC2086
{
  panel a 320 180 'the frame alone' "$work/alone/frame_0004.exr" $shown
  panel b 320 180 'with six views' "$work/corner/frame_0004.exr" $shown
  panel c 320 180 'path traced' "$folder/cache.png" --cut 320x180+648+0
}
oiiotool "$work/a.png" "$work/b.png" "$work/c.png" --mosaic:pad=4 3x1 \
  -o "$folder/cache.png"
