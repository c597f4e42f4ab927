# The centroids of the triangles of plate.msh (MSH 4.1, text) as a table of points:
#   awk -f points.awk plate.msh > points.csv
BEGIN { print "# made from plate.msh by points.awk: centroids of triangles, of a plate 1 m thick"
        print "x [mm],y [mm],volume [mm^3],region" }
/^\$/ { part = $1; line = 0; next }
{ ++line }
part == "$PhysicalNames" && line > 1 && $1 == 2 { gsub(/"/, "", $3); name[$2] = $3 }
# Entities: points, curves, then surfaces: tag, bounding box, number of groups, groups, ...
part == "$Entities" && line == 1 { skip = 1 + $1 + $2; next }
part == "$Entities" && line > skip { region[$1] = name[$9] }
# Nodes: blocks "dimension entity parametric count", count tags, count places.
part == "$Nodes" && line == 1 { next }
part == "$Nodes" && left == 0 { tags = left = $4; places = 0; next }
part == "$Nodes" && tags > 0 { tag[left - tags--] = $1; if (tags == 0) at = 0; next }
part == "$Nodes" { x[tag[at]] = $1; y[tag[at]] = $2; if (++at == left) left = 0; next }
# Elements: blocks "dimension entity type count", then tag and nodes.
part == "$Elements" && line == 1 { next }
part == "$Elements" && rows == 0 { dimension = $1; entity = $2; rows = $4; next }
part == "$Elements" {
  --rows
  if (dimension != 2) next
  area = ((x[$3] - x[$2]) * (y[$4] - y[$2]) - (x[$4] - x[$2]) * (y[$3] - y[$2])) / 2
  printf "%.8g,%.8g,%.8g,%s\n", (x[$2] + x[$3] + x[$4]) / 3, (y[$2] + y[$3] + y[$4]) / 3,
    1000 * (area < 0 ? -area : area), region[entity]
}
