# Run as a script: cmake -DOUT=file.cpp -DROOT=dir -DFOLDER=a/b -DTEXT=name -DFILE=f -DTABLE=name -DFILES=x,y -P EmbedFiles.cmake
# Writes a C++ file that holds each file's text as a raw string, so that the programs need no files beside them: FILE as the constant TEXT,
# and, if there is a TABLE, FILES as the table TABLE, both declared in FOLDER/embedded.h. Programs in Meld are named by their file, headers
# by their path below ROOT.
string(REPLACE "," ";" FILES "${FILES}")
get_filename_component(space ${FOLDER} NAME)
set(text "// Made by cmake/EmbedFiles.cmake.\n#include \"${FOLDER}/embedded.h\"\n\nnamespace meld::${space} {\n\n")

function(raw_string file result)
  file(READ ${file} content)
  # A raw string literal may hold at most 65,536 bytes; long files are split.
  string(LENGTH "${content}" length)
  set(pieces "")
  set(at 0)
  while(at LESS length)
    string(SUBSTRING "${content}" ${at} 12000 piece)
    string(APPEND pieces "R\"__MELD__(${piece})__MELD__\"\n")
    math(EXPR at "${at} + 12000")
  endwhile()
  set(${result} "${pieces}" PARENT_SCOPE)
endfunction()

raw_string(${FILE} pieces)
string(APPEND text "const char ${TEXT}[] = ${pieces};\n\n")

if(NOT TABLE)
  file(WRITE ${OUT} "${text}}  // namespace meld::${space}\n")
  return()
endif()
string(APPEND text "static const EmbeddedText files[] = {\n")
foreach(file IN LISTS FILES)
  if(file MATCHES "\\.meld$")
    get_filename_component(name ${file} NAME_WE)
  else()
    file(RELATIVE_PATH name ${ROOT} ${file})
  endif()
  raw_string(${file} pieces)
  string(APPEND text "{\"${name}\", ${pieces}},\n")
endforeach()
string(APPEND text "};\nconst std::span<const EmbeddedText> ${TABLE} = files;\n\n}  // namespace meld::${space}\n")
file(WRITE ${OUT} "${text}")
