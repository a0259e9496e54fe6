# Error against time of the providers of far light.  The lines in front of this
# script set data and picture.
set terminal pngcairo size 830,420 font "sans,10" noenhanced
set output picture
set grid lt 1 lw .5 lc rgb "#e0e0e0"
set offsets graph .12, graph .12, graph .14, graph .08
set xlabel "milliseconds of the whole frame, with all that the provider needs"
set ylabel "RMSE over that of the constant mean"
set key outside top center horizontal samplen 1 font "sans,9"
plot data index 0 using 1:2 with points pt 7 ps 1 lc rgb "#1f6fb4" title "all scenes", \
     data index 1 using 1:2 with points pt 6 ps 1 lc rgb "#d95f02" \
       title "scenes with a view from the light", \
     data index 2 using 1:2:3 with labels offset 0,1 font "sans,9" notitle
