# Force over displacement beside the measured curve. After running the scene and its variants:
#   gnuplot -d -c problems/l_panel/curves.gp problems/l_panel out curves.png
here = ARG1
out = ARG2
run(variant) = sprintf('%s/l_panel%s/history.csv', out, variant)
set terminal pngcairo size 1000,650 font 'sans,11'
set output ARG3
set datafile separator ','
set grid lc rgb '#dddddd'
set xlabel 'displacement at x = 470 mm (mm)'
set ylabel 'force (kN)'
set xrange [0:0.8]
set yrange [0:12]
set key top right
force(name) = column('pull.reaction.y')*1e-3
plot here.'/measured.csv' skip 1 using 1:($2*1e-3) with linespoints pt 7 ps 0.7 lw 1.5 lc rgb '#000000' title 'measured (Winkler 2001)', \
  here.'/measured.csv' skip 1 using ($1-$2*8.5e-6):($2*1e-3) with lines dt 2 lw 1.5 lc rgb '#000000' title 'measured, less 8.5 um/kN', \
  run('') using (0.8*column('time')):(force(0)) with lines lw 2 lc rgb '#0072b2' title 'cohesive, 89 J/m^2, 10 mm', \
  run('-fine') using (0.8*column('time')):(force(0)) with lines lw 2 dt 4 lc rgb '#0072b2' title '5 mm', \
  run('-paper_toughness') using (0.8*column('time')):(force(0)) with lines lw 2 lc rgb '#56b4e9' title 'cohesive, 65 J/m^2, 10 mm', \
  run('-paper_toughness_fine') using (0.8*column('time')):(force(0)) with lines lw 2 dt 4 lc rgb '#56b4e9' title '5 mm', \
  run('-rational') using (0.8*column('time')):(force(0)) with lines lw 1.5 lc rgb '#d55e00' title 'softening from the start, 89 J/m^2, 10 mm', \
  run('-rational_fine') using (0.8*column('time')):(force(0)) with lines lw 1.5 dt 4 lc rgb '#d55e00' title '5 mm'
