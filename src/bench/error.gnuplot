# Error against time, in two panels of 750 x 350 pixels, by which plot.c places
# the labels.  The lines in front of this script set data, picture and range: the
# lowest and highest time and error of each panel.
set terminal pngcairo size 830,905 font "sans,10" noenhanced
set output picture
set multiplot
set logscale xy
set xtics (.1,.2,.5,1,2,5,10,20,50,100,200,500,1000,2000,5000,10000)
set ytics (.0001,.0002,.0005,.001,.002,.005,.01,.02,.05,.1,.2,.5,1,2,5)
set grid lt 1 lw .5 lc rgb "#e0e0e0"
set lmargin at screen 60./830
set rmargin at screen 810./830
set xlabel "milliseconds of the whole frame" offset 0,.5
array titles[2] = ["E_near: RMSE / mean, against the exact integral", \
                   "AO: RMSE, against the exact integral"]
do for [panel = 0:1] {
  bottom = panel == 0 ? 510 : 80
  x0 = range[4 * panel + 1]; x1 = range[4 * panel + 2]
  y0 = range[4 * panel + 3]; y1 = range[4 * panel + 4]
  set bmargin at screen bottom / 905.
  set tmargin at screen (bottom + 350) / 905.
  set xrange [x0 : x1]
  set yrange [y0 : y1]
  set title titles[panel + 1] offset 0,-.5
  if (panel == 1) { set key at screen .5,.016 center horizontal samplen 1 width -1 font "sans,9" } else { unset key }
  n = 6 * panel
  plot data index n + 4 with lines lc rgb "#1f6fb4" lw 1.5 title "its front", \
       data index n with points pt 7 ps .7 lc rgb "#1f6fb4" title "default model", \
       data index n + 2 with points pt 7 ps .7 lc rgb "#999999" title "other models", \
       data index n + 1 with points pt 7 ps .7 lc rgb "#d95f02" title "paper's model", \
       data index n + 3 with points pt 5 ps 1 lc rgb "#000000" title "paper as one kernel", \
       data index n + 5 using (x0 * (x1 / x0) ** $1):(y0 * (y1 / y0) ** $2):3 \
         with labels left font "sans,8" notitle
}
unset multiplot
