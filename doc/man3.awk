# The public headers as man pages: hbil.3 from the comment at the beginning of
# hbil.h, and a page for each part of a header, named after the part's title.
#
#   awk -v version=V -v folder=DIR -f roff.awk -f man3.awk \
#     include/hbil/hbil.h include/hbil/hbil_*.h
#
# DIR/links gets a line "NAME PAGE" for every function and type that is on a
# page of another name.
#
# A header begins with a comment whose first line is "NAME: what it is".  In
# further headers the rest of this comment introduces their first part.  A part
# begins with a line of dashes and a title, each a comment of one line.  A blank
# line ends a comment and the declarations below it.

# Writes the prose of a comment in paragraphs.  Lines that are indented by more
# than `margin` are copied as they are.  Numbered lines become a list, and lines
# in capitals become headings.
function write_prose(text, margin,    lines, count, i, line, verbatim, begun) {
  count = split(text, lines, "\n")
  verbatim = 0
  begun = 0
  for (i = 1; i <= count; i++) {
    line = lines[i]
    if (verbatim && line !~ ("^" margin "  ") && line !~ /^$/) {
      print ".EE" > page
      verbatim = 0
      begun = 0
    }
    if (line ~ /^[A-Z][A-Z ]+$/) {
      print ".SH " line > page
      begun = 1
      continue
    }
    if (margin != "" && match(line, /^  +[0-9]\. /)) {
      print ".IP " substr(line, RLENGTH - 2, 2) " 4" > page
      line = substr(line, RLENGTH + 1)
      numbered = 1
    } else if (line ~ /^$/) {
      numbered = 0
      begun = 0
      continue
    } else if (!numbered && !verbatim && line ~ ("^" margin "  ")) {
      print ".PP\n.EX" > page
      verbatim = 1
      begun = 1
    } else if (!begun) {
      print ".PP" > page
      begun = 1
    }
    if (verbatim) {
      print code_line(line) > page
    } else {
      sub(/^ +/, "", line)
      print prose_line(line) > page
    }
  }
  if (verbatim)
    print ".EE" > page
  numbered = 0
}

function write_code(text,    lines, count, i) {
  print ".PP\n.EX" > page
  count = split(text, lines, "\n")
  for (i = 1; i <= count; i++)
    print code_line(lines[i]) > page
  print ".EE" > page
}

# Collects the names that a declaration introduces.
function note_names(code,    lines, count, i, name) {
  count = split(code, lines, "\n")
  for (i = 1; i <= count; i++) {
    name = ""
    if (code ~ /(^|\n)HBIL_API/ && match(lines[i], /hbil_[a-z0-9_]+\(/))
      name = substr(lines[i], RSTART, RLENGTH - 1)
    else if (match(lines[i], /^} hbil_[a-z0-9_]+;/))
      name = substr(lines[i], 3, RLENGTH - 3)
    else if (match(lines[i], /^typedef struct hbil_[a-z0-9_]+ hbil_[a-z0-9_]+;/)) {
      name = substr(lines[i], 1, RLENGTH - 1)
      sub(/.* /, "", name)
    }
    if (name != "" && !(name in names)) {
      names[name]
      listed = listed (listed == "" ? "" : ", ") name
      if (name != part)
        print name " " part > (folder "/links")
    }
  }
}

function end_comment_and_code() {
  if (comment != "" || code != "") {
    blocks++
    comments[blocks] = comment
    codes[blocks] = code
    if (code != "")
      note_names(code)
  }
  comment = code = ""
}

# A declaration without HBIL_API.  Lines that continue below a parenthesis move
# to the left with it.
function without_api(text) {
  gsub(/HBIL_API /, "", text)
  gsub(/\n             /, "\n    ", text)
  return text
}

function end_part(    i) {
  end_comment_and_code()
  if (part == "")
    return
  page = folder "/" part ".3"
  print page_head(part, 3) > page
  print ".SH NAME\n" listed " \\- " prose_line(tolower(title)) > page
  print ".SH SYNOPSIS\n.EX\n#include <" header ">" > page
  for (i = 1; i <= blocks; i++)
    if (codes[i] ~ /^HBIL_API/)
      print code_line(without_api(codes[i])) > page
  print ".EE\n.PP\n.EX\ncc program.c $(pkg\\-config \\-\\-cflags \\-\\-libs hbil)" \
    "\n.EE\n.SH DESCRIPTION" > page
  for (i = 1; i <= blocks; i++) {
    if (codes[i] ~ /^HBIL_API/) {
      write_code(without_api(codes[i]))
      if (comments[i] != "") {
        print ".RS 4" > page
        write_prose(comments[i], "")
        print ".RE" > page
      }
    } else {
      write_prose(comments[i], "")
      if (codes[i] != "")
        write_code(codes[i])
    }
  }
  print ".SH SEE ALSO\n.BR hbil (3)" > page
  close(page)
  pages[++page_count] = part
  about[page_count] = title
  blocks = 0
  listed = ""
}

function write_overview(    i) {
  page = folder "/hbil.3"
  print page_head("hbil", 3) > page
  sub(/^hbil: /, "", overview)
  sub(/\.$/, "", first)
  print ".SH NAME\nhbil \\- " prose_line(first) > page
  print ".SH SYNOPSIS\n.EX\n#include <hbil/hbil.h>\n.EE\n.PP\n.EX" > page
  print "cc program.c $(pkg\\-config \\-\\-cflags \\-\\-libs hbil)\n.EE" > page
  print ".SH DESCRIPTION" > page
  write_prose(overview, "  ")
  print ".SH PAGES" > page
  for (i = 1; i <= page_count; i++)
    print ".TP\n.BR " pages[i] " (3)\n" prose_line(about[i]) > page
  print ".SH SEE ALSO\n.BR hbil (1)" > page
  close(page)
}

function bare(line) {
  sub(/^ ?\/?\*+ ?/, "", line)
  sub(/ *\*\/ *$/, "", line)
  return line
}

FNR == 1 {
  end_part()
  part = ""
  header = FILENAME
  sub(/^.*include\//, "", header)
  introduction_done = 0
  introduction = ""
}

# the comment at the beginning of a header
part == "" && !introduction_done {
  if (/^ \*\/$/) {
    introduction_done = 1
    if (NR == FNR) {
      overview = introduction
      introduction = ""
    }
  } else if (/^ \* hbil: /) {
    first = $0
    sub(/^ \* hbil: /, "", first)
  } else if (!/^\/\*$/ && !/^ \* [a-z_.]+: /)
    introduction = introduction bare($0) "\n"
  next
}

/^\/\* -+ \*\/$/ { rule = 1; next }

rule {
  rule = 0
  end_part()
  title = bare($0)
  sub(/ +$/, "", title)
  part = title
  sub(/:.*/, "", part)
  gsub(/ /, "_", part)
  part = "hbil_" tolower(part)
  comment = introduction
  introduction = ""
  end_comment_and_code()
  next
}

part == "" || /^#(ifdef|endif)/ || /^}$/ { next }

in_comment {
  if (/\*\/$/)
    in_comment = 0
  if (!/^ \*\/$/)
    comment = comment "\n" bare($0)
  next
}

/^\/\*/ && code == "" {
  if (!/\*\/$/)
    in_comment = 1
  comment = comment (comment == "" || /^\/\*$/ ? "" : "\n") bare($0)
  next
}

# A blank line inside a struct does not end it.
/^$/ && code !~ /\{[^}]*$/ { end_comment_and_code(); next }

{ code = code (code == "" ? "" : "\n") $0 }

END {
  end_part()
  write_overview()
}
