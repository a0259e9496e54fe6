# Error and closed share by thickness, in two panels.  The lines in front of this
# script set data and picture.  An infinite thickness is drawn at 100.
set terminal pngcairo size 830,905 font "sans,10" noenhanced
set output picture
set multiplot
set logscale xy
set xrange [5e-7:200]
set xtics ("1e-6" 1e-6,"1e-5" 1e-5,"1e-4" 1e-4,".001" 1e-3,".01" .01,".1" .1,"1" 1,"10" 10,"infinite" 100)
set grid lt 1 lw .5 lc rgb "#e0e0e0"
set lmargin at screen 60./830
set rmargin at screen 810./830
set xlabel "thickness of occluders, world units" offset 0,.5
set key top left samplen 2 font "sans,9"
set format y "%g"
set bmargin at screen 510 / 905.
set tmargin at screen 860 / 905.
set title "Sampling error" offset 0,-.5
plot data using 1:5 with linespoints pt 7 ps .7 lc rgb "#d95f02" title "E_near, RMSE over the mean", \
     data using 1:4 with linespoints pt 7 ps .7 lc rgb "#1f6fb4" title "AO, RMSE"
set bmargin at screen 60 / 905.
set tmargin at screen 410 / 905.
set title "Closed share of the hemisphere, mean of 1 - AO" offset 0,-.5
plot data using 1:($3 > 0 ? $3 : NaN) with lines lw 3 lc rgb "#bbbbbb" title "exact integral", \
     data using 1:($2 > 0 ? $2 : NaN) with linespoints pt 7 ps .7 lc rgb "#1f6fb4" title "default sampling"
unset multiplot
