# Mean stress over extension for four spacings. After running the scene and its variants `half`,
# `quarter` and `eighth`:
#   gnuplot -d -c problems/cohesive_bar/curves.gp out PICTURE.png
out = ARG1
file(variant) = out.'/cohesive_bar'.variant.'/history.csv'
set terminal pngcairo size 900,560 font 'sans,11'
set output ARG2
set datafile separator ','
set grid lc rgb '#dddddd'
set xlabel 'extension (um)'
set ylabel 'mean stress (MPa)'
set xrange [0:100]
set yrange [0:3]
set key at 98, 2.6 top right
plot 2.7 with lines dt 2 lw 1.5 lc rgb '#444444' title 'strength', \
  file('') using ($1*120):(column('right.reaction.x')/0.16e6) with lines lw 2 lc rgb '#0072b2' title '5 mm', \
  file('-half') using ($1*120):(column('right.reaction.x')/0.08e6) with lines lw 2 lc rgb '#009e73' title '2.5 mm', \
  file('-quarter') using ($1*120):(column('right.reaction.x')/0.04e6) with lines lw 2 lc rgb '#e69f00' title '1.25 mm', \
  file('-eighth') using ($1*120):(column('right.reaction.x')/0.02e6) with lines lw 2 lc rgb '#d55e00' title '0.625 mm'
