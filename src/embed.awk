# Turns kernel files into one C table of strings, each line a literal of its
# own (so no compiler's limit on a literal's length is near).
function base(path) { sub(/^.*\//, "", path); return path }
BEGIN {
  print "/* Generated from kernels/ by embed.awk. */"
  print "#include \"internal.h\"\n"
  print "const kernel_source kernel_sources[] = {"
}
FNR == 1 { if (NR > 1) print "     },"; printf "    {\"%s\",\n", base(FILENAME) }
{
  gsub(/\\/, "&&"); gsub(/"/, "\\\"")
  printf "     \"%s\\n\"\n", $0
}
END { print "     },\n    {0, 0},\n};" }
