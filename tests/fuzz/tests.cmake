# Two targets, each as a replay of files with any compiler (run by ctest) and, in the preset `fuzz` with Clang, as a
# libFuzzer program (run by scripts/fuzz).
set(fuzz_layers compiler_driver)
foreach(target front_end compile)
  add_executable(fuzz_${target}_replay fuzz/${target}_target.cpp fuzz/front_end.cpp fuzz/mutate.cpp fuzz/replay.cpp)
  target_link_libraries(fuzz_${target}_replay PRIVATE ${fuzz_layers})
  if(CLAYMELD_FUZZ)
    add_executable(fuzz_${target} fuzz/${target}_target.cpp fuzz/front_end.cpp fuzz/mutate.cpp fuzz/mutator.cpp)
    target_link_libraries(fuzz_${target} PRIVATE ${fuzz_layers})
    target_link_options(fuzz_${target} PRIVATE -fsanitize=fuzzer)
  endif()
endforeach()
set(fuzz_seeds ${CMAKE_SOURCE_DIR}/tests/fuzz/found ${CMAKE_SOURCE_DIR}/tests/meld ${CMAKE_SOURCE_DIR}/examples/meld
               ${CMAKE_SOURCE_DIR}/tests/retraction)
add_test(NAME fuzz_front_end_replay COMMAND fuzz_front_end_replay --mutations 40 ${fuzz_seeds})
add_test(NAME fuzz_compile_replay COMMAND fuzz_compile_replay ${CMAKE_SOURCE_DIR}/tests/fuzz/found)
