# Run as a script: cmake -DOUT=file.cpp -DROOT=dir -DPRELUDE=a -DEXTERN=b -DLIBRARIES=x,y -DHEADERS=z -P EmbedFiles.cmake
# Writes a C++ file that holds each file's text as a raw string, so that the programs need no files beside them.
# LIBRARIES and HEADERS become tables: libraries by the name of the file, headers by their path below ROOT.
string(REPLACE "," ";" LIBRARIES "${LIBRARIES}")
string(REPLACE "," ";" HEADERS "${HEADERS}")
set(text "// Made by cmake/EmbedFiles.cmake.\n#include \"compiler/driver/embedded.h\"\n\nnamespace meld::driver {\n\n")

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

raw_string(${PRELUDE} pieces)
string(APPEND text "const char kPrelude[] = ${pieces};\n\n")
raw_string(${EXTERN} pieces)
string(APPEND text "const char kExtern[] = ${pieces};\n\n")

string(APPEND text "static const EmbeddedText libraries[] = {\n")
foreach(file IN LISTS LIBRARIES)
  get_filename_component(name ${file} NAME_WE)
  raw_string(${file} pieces)
  string(APPEND text "{\"${name}\", ${pieces}},\n")
endforeach()
string(APPEND text "};\nconst std::span<const EmbeddedText> kLibraries = libraries;\n\n")

string(APPEND text "static const EmbeddedText headers[] = {\n")
foreach(file IN LISTS HEADERS)
  file(RELATIVE_PATH name ${ROOT} ${file})
  raw_string(${file} pieces)
  string(APPEND text "{\"${name}\", ${pieces}},\n")
endforeach()
string(APPEND text "};\nconst std::span<const EmbeddedText> kModuleHeaders = headers;\n\n}  // namespace meld::driver\n")
file(WRITE ${OUT} "${text}")
