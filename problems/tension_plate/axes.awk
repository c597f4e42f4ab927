# awk -v name=u -f axes.awk TABLE.csv history.csv: place, displacement and its difference from the
# table (m) at the probes u00 .. u20 along x, or v00 .. v20 along y.
function place(k) {
  if (k == 20) return name == "u" ? 0.495 : 0.4975
  return name == "v" || k < 10 ? -0.4975 + 0.05*k : 0.005 + 0.05*(k - 10)
}
function reference(x,   i, share) {
  i = int((x + 0.5)/0.005 + 1e-6)
  if (i > rows - 2) i = rows - 2
  share = (x - key[i])/0.005
  return (1 - share)*value[i] + share*value[i + 1]
}
BEGIN { FS = ","; rows = 0; component = name == "u" ? "x" : "y" }
FNR == NR { if ($1 + 0 == $1) { key[rows] = $1; value[rows++] = $2 } next }
FNR == 1 { for (i = 1; i <= NF; i++) title[i] = $i }
{ last = $0 }
END {
  split(last, found, ",")
  for (i in title)
    if (title[i] ~ "^" name "[0-9][0-9].displacement." component "$") {
      k = substr(title[i], 2, 2) + 0
      at[k] = found[i]
    }
  for (k = 0; k <= 20; k++) print place(k), at[k], at[k] - reference(place(k))
}
