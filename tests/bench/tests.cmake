# Benchmarks are built and run once on small worlds, so that they never rot; figures come from docs/benchmarks.md.
foreach(bench gradient shape rows programs graph timeline query watch balance)
  add_executable(bench_${bench} ${CMAKE_CURRENT_SOURCE_DIR}/bench/bench_${bench}.cpp)
  target_link_libraries(bench_${bench} PRIVATE runtime_driver)
endforeach()
add_test(NAME bench_gradient_small COMMAND bench_gradient ${CMAKE_SOURCE_DIR}/examples/meld/gradient.meld 12)
add_test(NAME bench_shape_small COMMAND bench_shape ${CMAKE_SOURCE_DIR}/examples/meld/shape_change.meld 22)
add_test(NAME bench_timeline_small COMMAND bench_timeline ${CMAKE_SOURCE_DIR}/examples/meld/gradient.meld 10)
add_test(NAME bench_query_small COMMAND bench_query ${CMAKE_SOURCE_DIR}/examples/meld/gradient.meld 10)
add_test(NAME bench_watch_small COMMAND bench_watch ${CMAKE_SOURCE_DIR}/examples/meld/gradient.meld 8)
add_test(NAME bench_latency_small
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/bench_latency.py
                 $<TARGET_FILE_DIR:meldc> ${CMAKE_SOURCE_DIR}/examples/meld 1000)
add_test(NAME bench_networks_small
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/bench_networks.py
                 $<TARGET_FILE_DIR:meldsim> ${CMAKE_SOURCE_DIR}/examples/meld --side 10 --runs 1)
add_test(NAME bench_why_small
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/bench_why.py
                 $<TARGET_FILE_DIR:meldc> ${CMAKE_SOURCE_DIR}/examples/meld 1000)
add_test(NAME bench_checkpoint_small
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/bench_checkpoint.py
                 $<TARGET_FILE_DIR:meldsim> ${CMAKE_SOURCE_DIR}/examples/meld 1000)
add_test(NAME bench_checkpoint_bodies_small
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/bench_checkpoint.py
                 $<TARGET_FILE_DIR:meldsim> ${CMAKE_SOURCE_DIR}/examples/meld --bodies 1000)
add_test(NAME bench_first_picture_small
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/bench_first_picture.py
                 $<TARGET_FILE_DIR:meldsim> ${CMAKE_SOURCE_DIR}/examples/meld --times 1 --size 600x400 1000)
set_tests_properties(bench_first_picture_small PROPERTIES PROCESSORS 2 TIMEOUT 180)
add_test(NAME bench_view_frames_small
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/bench_view_frames.py
                 $<TARGET_FILE_DIR:meldsim> ${CMAKE_SOURCE_DIR}/examples/meld --frames 2 1000)
add_test(NAME bench_tables_small
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/bench_tables.py $<TARGET_FILE_DIR:meldc> --short)
add_test(NAME bench_observed_small
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/bench_observed.py
                 $<TARGET_FILE_DIR:meldc> ${CMAKE_SOURCE_DIR}/examples/meld --side 10 --runs 1)
add_test(NAME bench_balance_small COMMAND bench_balance ${CMAKE_CURRENT_LIST_DIR}/balance/storm.meld 24 3 64)
add_test(NAME bench_rows_small COMMAND bench_rows $<TARGET_FILE:meldc> ${CMAKE_CURRENT_LIST_DIR}/rows small)

add_test(NAME bench_programs_small
         COMMAND bench_programs ${CMAKE_SOURCE_DIR}/examples/meld ${CMAKE_CURRENT_LIST_DIR}/programs small)
add_test(NAME bench_graph_small
         COMMAND bench_graph ${CMAKE_SOURCE_DIR}/examples/meld ${CMAKE_CURRENT_LIST_DIR}/graphs small)

add_executable(bench_physics ${CMAKE_CURRENT_SOURCE_DIR}/bench/bench_physics.cpp)
target_link_libraries(bench_physics PRIVATE physics_scene)
add_test(NAME bench_physics_small COMMAND bench_physics --ticks 3 6)

add_executable(bench_burst ${CMAKE_CURRENT_SOURCE_DIR}/bench/bench_burst.cpp)
target_link_libraries(bench_burst PRIVATE physics_scene)
add_test(NAME bench_burst_small COMMAND bench_burst --ticks 3 6)

add_executable(bench_composites ${CMAKE_CURRENT_SOURCE_DIR}/bench/bench_composites.cpp)
target_link_libraries(bench_composites PRIVATE physics_scene)
add_test(NAME bench_composites_small COMMAND bench_composites --ticks 3 6)
add_executable(bench_joints ${CMAKE_CURRENT_SOURCE_DIR}/bench/bench_joints.cpp)
target_link_libraries(bench_joints PRIVATE physics_scene)
add_test(NAME bench_joints_small COMMAND bench_joints --ticks 3 200)
add_executable(bench_shapes ${CMAKE_CURRENT_SOURCE_DIR}/bench/bench_shapes.cpp)
target_link_libraries(bench_shapes PRIVATE physics_scene)
add_test(NAME bench_shapes_small COMMAND bench_shapes --ticks 3 5)

add_executable(bench_engines ${CMAKE_CURRENT_SOURCE_DIR}/bench/bench_engines.cpp)
target_link_libraries(bench_engines PRIVATE physics_scene)
add_test(NAME bench_engines_small
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/bench_engines.py $<TARGET_FILE_DIR:bench_engines> --short)

add_executable(bench_mechanics ${CMAKE_CURRENT_SOURCE_DIR}/bench/bench_mechanics.cpp)
target_link_libraries(bench_mechanics PRIVATE physics_scene)
add_test(NAME bench_mechanics COMMAND bench_mechanics)

add_executable(bench_picture ${CMAKE_CURRENT_SOURCE_DIR}/bench/bench_picture.cpp)
target_link_libraries(bench_picture PRIVATE runtime_show_render runtime_world)
add_test(NAME bench_picture_small COMMAND bench_picture 12 fcc)

add_executable(bench_front_end ${CMAKE_CURRENT_SOURCE_DIR}/bench/bench_front_end.cpp)
target_link_libraries(bench_front_end PRIVATE compiler_driver)
add_test(NAME bench_front_end_small COMMAND bench_front_end 60)
add_test(NAME bench_bodies_small
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/bench_bodies.py $<TARGET_FILE_DIR:meldsim> --short 8)
set_tests_properties(bench_bodies_small PROPERTIES PROCESSORS 2)

add_executable(bench_halo ${CMAKE_CURRENT_SOURCE_DIR}/bench/bench_halo.cpp)
target_link_libraries(bench_halo PRIVATE runtime_world_partition)
add_test(NAME bench_halo_small COMMAND bench_halo 64)
