# Run as a script: cmake -DOUT=file.cpp -DNAMES=a,b -DFILES=x,y -DLIBRARIES=z -P EmbedFiles.cmake
# Writes a C++ file that holds each file's text as a raw string, so that the programs need no files beside them.
# NAMES are the variables of FILES; LIBRARIES become the table kLibraries, each by the name of its file.
string(REPLACE "," ";" NAMES "${NAMES}")
string(REPLACE "," ";" FILES "${FILES}")
string(REPLACE "," ";" LIBRARIES "${LIBRARIES}")
set(text "// Made by cmake/EmbedFiles.cmake.\n#include \"compiler/driver/embedded.h\"\n\nnamespace meld::driver {\n\n")

function(raw_string file result)
  file(READ ${file} content)
  # A raw string literal may hold at most 65,536 bytes; long files are split at newlines.
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

foreach(name file IN ZIP_LISTS NAMES FILES)
  raw_string(${file} pieces)
  string(APPEND text "const char ${name}[] = ${pieces};\n\n")
endforeach()
string(APPEND text "static const EmbeddedLibrary libraries[] = {\n")
foreach(file IN LISTS LIBRARIES)
  get_filename_component(name ${file} NAME_WE)
  raw_string(${file} pieces)
  string(APPEND text "{\"${name}\", ${pieces}},\n")
endforeach()
string(APPEND text "};\nconst std::span<const EmbeddedLibrary> kLibraries = libraries;\n\n}  // namespace meld::driver\n")
file(WRITE ${OUT} "${text}")
