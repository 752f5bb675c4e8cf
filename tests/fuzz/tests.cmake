# Five targets, each as a replay of files with any compiler (run by ctest) and, in the preset `fuzz` with Clang, as a
# libFuzzer program (run by scripts/fuzz).
function(fuzz_target target)
  cmake_parse_arguments(arg "" "" "SOURCES;MUTATOR;DEPENDS" ${ARGN})
  add_executable(fuzz_${target}_replay fuzz/${target}_target.cpp ${arg_SOURCES} fuzz/mutate.cpp fuzz/replay.cpp)
  target_link_libraries(fuzz_${target}_replay PRIVATE ${arg_DEPENDS})
  if(CLAYMELD_FUZZ)
    add_executable(fuzz_${target} fuzz/${target}_target.cpp ${arg_SOURCES} ${arg_MUTATOR})
    target_link_libraries(fuzz_${target} PRIVATE ${arg_DEPENDS})
    target_link_options(fuzz_${target} PRIVATE -fsanitize=fuzzer)
  endif()
endfunction()
foreach(target front_end compile)
  fuzz_target(${target} SOURCES fuzz/front_end.cpp MUTATOR fuzz/mutate.cpp fuzz/mutator.cpp DEPENDS compiler_driver)
endforeach()
fuzz_target(world SOURCES MUTATOR fuzz/mutate.cpp fuzz/mutator.cpp DEPENDS runtime_world)
# Its files are no text, so libFuzzer changes them by itself.
fuzz_target(share DEPENDS runtime_sim)
fuzz_target(dap DEPENDS runtime_ask_dap runtime_ask_debug)
set(fuzz_seeds ${CMAKE_SOURCE_DIR}/tests/fuzz/found ${CMAKE_SOURCE_DIR}/tests/meld ${CMAKE_SOURCE_DIR}/examples/meld
               ${CMAKE_SOURCE_DIR}/tests/retraction)
add_test(NAME fuzz_front_end_replay COMMAND fuzz_front_end_replay --mutations 10 ${fuzz_seeds})
add_test(NAME fuzz_front_end_mutations COMMAND fuzz_front_end_replay --mutations 60 ${fuzz_seeds})
add_test(NAME fuzz_world_replay COMMAND fuzz_world_replay --mutations 3000 ${CMAKE_SOURCE_DIR}/tests/fuzz/worlds
  ${CMAKE_SOURCE_DIR}/tests/fuzz/found_worlds)
add_test(NAME fuzz_dap_replay COMMAND fuzz_dap_replay --mutations 4000 ${CMAKE_SOURCE_DIR}/tests/fuzz/commands)
add_test(NAME fuzz_share_replay COMMAND fuzz_share_replay --mutations 2000 ${CMAKE_SOURCE_DIR}/tests/fuzz/shares)
add_test(NAME fuzz_compile_replay COMMAND fuzz_compile_replay ${CMAKE_SOURCE_DIR}/tests/fuzz/found)
