# Error against time, in two panels.  The lines in front of this script set data
# and picture.
set terminal pngcairo size 830,905 font "sans,10" noenhanced
set output picture
array range[8] # lowest and highest logarithms of times and of errors
do for [panel = 0:1] {
  stats data index 6 * panel : 6 * panel + 3 using (log10($1)):(log10($2)) nooutput
  range[4 * panel + 1] = STATS_min_x - .12
  range[4 * panel + 2] = STATS_max_x + .08
  range[4 * panel + 3] = STATS_min_y - .12
  range[4 * panel + 4] = STATS_max_y + .08
}
set multiplot
set logscale xy
set xtics (.1,.2,.5,1,2,5,10,20,50,100,200,500,1000,2000,5000,10000)
set ytics (.0001,.0002,.0005,.001,.002,.005,.01,.02,.05,.1,.2,.5,1,2,5)
set grid lt 1 lw .5 lc rgb "#e0e0e0"
set lmargin at screen 60./830
set rmargin at screen 810./830
set xlabel "milliseconds of the whole frame" offset 0,.5
array titles[2] = ["Indirect light (E_near): sampling error, RMSE over the mean", \
                   "Ambient occlusion: sampling error, RMSE"]
do for [panel = 0:1] {
  bottom = panel == 0 ? 510 : 80
  set bmargin at screen bottom / 905.
  set tmargin at screen (bottom + 350) / 905.
  n = 6 * panel
  set xrange [10 ** range[4 * panel + 1] : 10 ** range[4 * panel + 2]]
  set yrange [10 ** range[4 * panel + 3] : 10 ** range[4 * panel + 4]]
  set title titles[panel + 1] offset 0,-.5
  if (panel == 1) { set key at screen .5,.016 center horizontal maxrows 2 samplen 1 width -2 font "sans,9" } else { unset key }
  plot data index n with points pt 7 ps .7 lc rgb "#1f6fb4" title "default model", \
       data index n + 4 with lines lc rgb "#1f6fb4" lw 1.5 title "its best settings", \
       data index n + 1 with points pt 7 ps .7 lc rgb "#d95f02" title "the paper's model", \
       data index n + 2 with points pt 7 ps .7 lc rgb "#999999" title "other thickness, or AO alone", \
       data index n + 3 with points pt 5 ps 1 lc rgb "#000000" title "as one plain kernel", \
       data index n + 5 using 1:2:3 with labels right offset -.5,-.6 font "sans,9" notitle
}
unset multiplot
