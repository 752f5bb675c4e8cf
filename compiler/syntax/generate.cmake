# The scanner and the grammar, made into C++ by flex and bison below the build folder. Their warnings are not ours.
find_package(FLEX 2.6 REQUIRED)
find_package(BISON 3.8 REQUIRED)

set(syntax_source ${CMAKE_SOURCE_DIR}/compiler/syntax)
set(syntax_output ${CMAKE_BINARY_DIR}/generated/compiler/syntax)
file(MAKE_DIRECTORY ${syntax_output})
flex_target(meld_scanner ${syntax_source}/scan.l ${syntax_output}/scan.cpp)
bison_target(meld_grammar ${syntax_source}/grammar.y ${syntax_output}/grammar.cpp
  DEFINES_FILE ${syntax_output}/grammar.h COMPILE_FLAGS "-Wall -Werror=conflicts-sr -Werror=conflicts-rr")
set(generated ${FLEX_meld_scanner_OUTPUTS} ${syntax_output}/grammar.cpp)
set_source_files_properties(${generated} PROPERTIES COMPILE_OPTIONS "-w" SKIP_UNITY_BUILD_INCLUSION ON)
