#!/bin/sh
# `hbil compare` of files as they are: channels without a layer, layers by short
# names, two view layers, eyes, and every format that is read.
. "$srcdir/test/support/tap.sh"

compare() {
  "$HBIL" compare --max-rmse "$@"
}
for tool in oiiotool; do
  command -v $tool >/dev/null || {
    skip "compare" "no $tool"
    echo "1..$count"
    exit 0
  }
done

# ramp FILE TOP LEFT CHANNELS [WORDS...]: a file whose channels are all different.
ramp() {
  file=$1 names=$2 most=$3
  shift 3
  number=$(echo "$names" | tr ',' '\n' | wc -l)
  colours=$(awk -v n="$number" -v most="$most" 'BEGIN {
    for (i = 1; i <= n; i++) printf "%s%g", (i > 1 ? "," : ""), most * i / n }')
  none=$(echo "$colours" | sed 's/[0-9.e-]*/0/g; s/00*/0/g')
  oiiotool --pattern "fill:left=$none:right=$colours" 16x8 "$number" \
    --chnames "$names" "$@" -o "$file" >"$work/out" 2>&1
}
cd "$work" || exit 99

ramp root.exr R,G,B 3
ramp named.exr indirect.R,indirect.G,indirect.B,ao.V 4
ramp alpha.exr R,G,B,A 4
ramp two.exr BG.only.DiffInd.R,BG.only.DiffInd.G,BG.only.DiffInd.B,Fore.DiffInd.R,Fore.DiffInd.G,Fore.DiffInd.B 6
ramp one.exr ViewLayer.DiffInd.R,ViewLayer.DiffInd.G,ViewLayer.DiffInd.B,ViewLayer.DiffIndirect.R 4
ramp eyes.exr ViewLayer.DiffInd.left.R,ViewLayer.DiffInd.left.G,ViewLayer.DiffInd.left.B 3
ramp eight.png R,G,B .9 -d uint8
has "files to compare" root.exr named.exr alpha.exr two.exr one.exr eyes.exr eight.png

# --- channels without a layer ---

works "a layer here, channels without a layer there" compare 1e-6 named.exr:indirect root.exr
works "and the other way round" compare 1e-6 root.exr named.exr:indirect
works "a colon says so" compare 1e-6 named.exr:indirect root.exr:
works "alpha isn't compared" compare 1e-6 root.exr: alpha.exr:
rejected "where there are none" \
  'named.exr: has no channels without a layer; one of ao, indirect is needed' \
  compare 1 named.exr: root.exr
differs "another channel is another" compare 1e-3 named.exr:ao.V root.exr:B

# --- names ---

works "a short name" compare 1e-6 one.exr:DiffInd root.exr
works "with an eye behind it" compare 1e-6 eyes.exr:DiffInd root.exr
works "a single channel, which is compared with a single one" \
  compare 1e-6 one.exr:DiffInd.G root.exr:G
rejected "two view layers" \
  'two.exr: DiffInd is the name of several layers; one of BG.only.DiffInd, Fore.DiffInd is needed' \
  compare 1 two.exr:DiffInd root.exr
works "one of them" compare 1e-6 two.exr:only.DiffInd two.exr:BG.only.DiffInd
differs "the other one" compare 1e-3 two.exr:Fore.DiffInd two.exr:BG.only.DiffInd
rejected "a name that isn't there" \
  'one.exr: has no layer DiffIn; one of ViewLayer.DiffInd, ViewLayer.DiffIndirect is needed' \
  compare 1 one.exr:DiffIn root.exr:
rejected "in neither file" 'root.exr: has no layer glow; one of [RGB], [RGB], [RGB] is needed' \
  compare 1 root.exr:glow alpha.exr:glow

# --- means over blocks ---

# a checkerboard has the mean of its two colours in every block of two
oiiotool --pattern checker:width=1:height=1:color1=0,0,0:color2=1,1,1 15x8 3 \
  -o checker.exr --pattern constant:color=.5,.5,.5 15x8 3 -o grey.exr >out 2>&1
differs "a checkerboard isn't grey" compare 0.49 checker.exr grey.exr
# the last column's blocks are half as wide, and grey as well
works "its blocks are" compare 1e-6 --blocks 2 checker.exr grey.exr
differs "blocks of an odd width aren't" compare 1e-3 --blocks 3 checker.exr grey.exr
works "a block as large as the picture" compare 1e-6 --blocks 256 checker.exr grey.exr
rejected "no pixel to a block" 'from 1 to 256' compare 1 --blocks 0 checker.exr grey.exr

# --- data windows ---

# Two parts of one picture, as large as each other, and one of another picture.
oiiotool root.exr --crop 8x6+2+1 -o left.exr root.exr --crop 8x6+6+2 -o right.exr \
  --origin +0+0 --fullpixels -o first.exr root.exr --crop 2x2+0+0 -o corner.exr \
  root.exr --crop 8x6+2+1 --fullpixels -o part.exr >out 2>&1
works "parts of a picture have the same pixels" compare 1e-6 left.exr right.exr
grep -q 'left.exr: only its 4 x 5 pixels at 6, 2 are compared' err && grep -q '^values  *60$' out
ok $? "where they overlap, which is told"
works "a part and the whole" compare 1e-6 root.exr left.exr
works "a part that has a window of its own" compare 1e-6 part.exr root.exr
rejected "parts that don't overlap" 'corner.exr: none of its pixels are in the data window of right' \
  compare 1 corner.exr right.exr
run compare 1e-6 right.exr first.exr
test $status -eq 0 && grep -q 'warning: its pixels are at 6, 2, and those of .* at 0, 0; they are' err
ok $? "another picture of that size is compared as it is, with a warning"
works "pictures of one window" compare 1e-6 left.exr left.exr
test ! -s err
ok $? "have nothing to be told"

# --- heat maps ---

rejected "a heat map that is no PNG" 'map.jpg: --heatmap writes PNG alone; a name that ends in .png' \
  compare 1 --heatmap map.jpg root.exr alpha.exr:
works "a heat map" compare 9 --heatmap map.PNG root.exr root.exr

# --- formats ---

for other in tif hdr; do
  oiiotool root.exr -o "root.$other" >out 2>&1
  # RGBE has eight bits
  works "EXR and $other" compare 1e-2 root.exr "root.$other"
  differs "$other is read" compare 1e-2 named.exr:ao.V "root.$other:R"
done
works "a PNG and itself" compare 0 eight.png eight.png
oiiotool eight.png --colorconvert sRGB linear -d float -o linear.exr >out 2>&1
works "the sRGB of a PNG becomes linear" compare 1e-3 eight.png linear.exr
oiiotool eight.png -d float --attrib oiio:ColorSpace linear -o encoded.exr >out 2>&1
differs "which is not what is stored" compare 1e-2 eight.png encoded.exr
rejected "other numbers of channels" \
  '4 channels, but .* has 3; FILE:LAYER with the same channels' compare 1 named.exr root.exr

# --- what renderers wrote ---

files=$HBIL_DATA/renderers
if test -d "$files"; then
  works "Mitsuba's root channels" compare 10 \
    "$files/mitsuba/cbox.exr:" "$files/mitsuba/cbox_truth.exr:"
  rejected "Blender's two view layers" 'one of BG.only.DiffInd, Foreground Layer.DiffInd' \
    compare 1 "$files/blender42/c_twolayers.exr:DiffInd" root.exr
  works "one of them" compare 10 "$files/blender42/c_twolayers.exr:BG.only.DiffInd" \
    "$files/blender42/c_twolayers.exr:Foreground Layer.DiffInd"
else
  for name in "Mitsuba's root channels" "Blender's two view layers" "one of them"; do
    skip "$name" "no files in $files"
  done
fi

cd / || exit 99
echo "1..$count"
