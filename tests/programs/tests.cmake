# The example programs, each in several worlds, on several numbers of processes and threads; the campaign takes more numbers.
foreach(program gradient spanning_tree leader census temperature flood height_colour thermometer walk
        life shortest_paths relaxation pagerank pagerank_async bipartite colouring minimum_spanning_tree consensus
        queens quicksort belief_propagation mutual_exclusion localization kmeans heat)
  meld_sizes_test(program_${program} ${CMAKE_CURRENT_LIST_DIR}/program_test.py $<TARGET_FILE:meldsim> ${CMAKE_SOURCE_DIR}/examples/meld
    ${program})
endforeach()
# 10,000 catoms are many for a run on several processes.
set_tests_properties(program_localization_sizes PROPERTIES TIMEOUT 1200)
# Distributed algorithms, beside the bounds of their papers: on random lattices, and on graphs where messages are late and lost.
foreach(program echo diffusing articulation snapshot alternating_bit luby fragments token_ring stabilizing_tree gossip reliable_broadcast
        raymond echo_election triangles byzantine)
  meld_sizes_test(distributed_${program} ${CMAKE_CURRENT_LIST_DIR}/distributed_test.py $<TARGET_FILE:meldsim>
    ${CMAKE_SOURCE_DIR}/examples/meld ${program})
  meld_sizes_test(conditions_${program} ${CMAKE_CURRENT_LIST_DIR}/conditions_test.py $<TARGET_FILE:meldsim>
    ${CMAKE_SOURCE_DIR}/examples/meld ${program})
endforeach()
# The same, with crashes, links that break, and programs that are broken in one place.
foreach(program vector_clocks dining_philosophers synchronizer link_reversal k_core failure_detector chandra_toueg paxos distance_vector
        link_state)
  meld_sizes_test(textbook_${program} ${CMAKE_CURRENT_LIST_DIR}/textbook_test.py $<TARGET_FILE:meldsim> ${CMAKE_SOURCE_DIR}/examples/meld
    ${program})
endforeach()
# On graphs, files among them, where messages are late and lost: programs that program_test.py runs on lattices.
foreach(program leader flood_election pagerank pagerank_async)
  meld_sizes_test(conditions_${program} ${CMAKE_CURRENT_LIST_DIR}/conditions_test.py $<TARGET_FILE:meldsim>
    ${CMAKE_SOURCE_DIR}/examples/meld ${program})
endforeach()
# What is read where it was written, beside what is delivered.
add_test(NAME broadcasts COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/broadcasts_test.py --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(broadcasts PROPERTIES TIMEOUT 300 PROCESSORS 2)
# The set-up, on all threads.
meld_sizes_test(program_setup ${CMAKE_CURRENT_LIST_DIR}/setup_test.py $<TARGET_FILE:meldsim>)
# Catoms that die while others go on.
foreach(program walking_token shape_change)
  meld_sizes_test(failures_${program} ${CMAKE_CURRENT_LIST_DIR}/failures_test.py $<TARGET_FILE:meldsim> ${CMAKE_SOURCE_DIR}/examples/meld
    ${program})
endforeach()
# The table of their costs in docs/algorithms.md.
add_test(NAME costs COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/costs_test.py $<TARGET_FILE:meldsim>)
set_tests_properties(costs PROPERTIES TIMEOUT 300 PROCESSORS 2)

# The invariants of shape change, watched from inside.
meld_test(test_shape_change SOURCES ${CMAKE_CURRENT_LIST_DIR}/shape_change_test.cpp DEPENDS runtime/driver)
target_compile_definitions(test_shape_change PRIVATE CLAYMELD_EXAMPLES="${CMAKE_SOURCE_DIR}/examples/meld")
add_dependencies(test_shape_change meldc)
add_test(NAME program_recording
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/recording_test.py $<TARGET_FILE:meldsim> ${CMAKE_SOURCE_DIR}/examples/meld)
set_tests_properties(program_recording PROPERTIES TIMEOUT 120 PROCESSORS 2)
meld_sizes_test(program_shape_change ${CMAKE_CURRENT_LIST_DIR}/shape_test.py $<TARGET_FILE:meldsim> ${CMAKE_SOURCE_DIR}/examples/meld)
# Examples whose catoms are bodies.
foreach(program swarm rolling planar_catoms planar_ring row bridge ring climber cantilever launched_bridge cube_bridge m_blocks snake
        two_wheeler fetcher walker phototaxis lantern electrostatic_cubes conveyor mixing_pan)
  add_test(NAME motion_${program}
           COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/motion_test.py $<TARGET_FILE:meldsim> ${CMAKE_SOURCE_DIR}/examples/meld
           ${program})
  set_tests_properties(motion_${program} PROPERTIES TIMEOUT 600 PROCESSORS 2)
endforeach()
add_test(NAME motion_crowd
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/motion_test.py
                 $<TARGET_FILE:meldsim> ${CMAKE_CURRENT_LIST_DIR}/bodies crowd)
set_tests_properties(motion_crowd PROPERTIES TIMEOUT 300 PROCESSORS 2)
# Random wishes, and random changes of all kinds: some seeds, and many more in NAME_more, a long test.
function(meld_seeds_test name script first seeds more)
  math(EXPR rest "${first} + ${seeds}")
  set(command ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/${script} $<TARGET_FILE:meldsim>)
  add_test(NAME ${name} COMMAND ${command} ${first} ${seeds})
  add_test(NAME ${name}_more COMMAND ${command} ${rest} ${more})
  set_tests_properties(${name} ${name}_more PROPERTIES TIMEOUT 600 PROCESSORS 2)
  set_tests_properties(${name}_more PROPERTIES LABELS long)
endfunction()
meld_seeds_test(motion_wishes wishes_test.py 0 8 16)
# Four seeds are one for each way in which amoebots take turns; only sixteen are sure to see all that can happen.
meld_seeds_test(motion_amoebots amoebots_test.py 0 4 16)
# A seed for each table of moves, of which most wait for the long tests.
meld_seeds_test(motion_moves moves_test.py 0 4 28)
meld_seeds_test(motion_connected connected_test.py 0 3 21)
meld_seeds_test(motion_storm storm_test.py 0 2 2)
meld_seeds_test(motion_tumble tumbling/tumble_test.py 0 1 13)
meld_seeds_test(motion_mechanisms tumbling/mechanisms_test.py 0 3 21)
meld_seeds_test(motion_composites tumbling/composites_test.py 0 3 37)
meld_seeds_test(motion_arms tumbling/arms_test.py 0 2 10)
meld_seeds_test(motion_couplings tumbling/couplings_test.py 0 2 18)
meld_seeds_test(motion_grips grips_test.py 0 2 26)
add_test(NAME motion_compression
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/compression_test.py
                 $<TARGET_FILE:meldsim> ${CMAKE_SOURCE_DIR}/examples/meld)
set_tests_properties(motion_compression PROPERTIES TIMEOUT 300 PROCESSORS 2)
add_test(NAME motion_pivoting
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/pivoting_test.py $<TARGET_FILE:meldsim> ${CMAKE_SOURCE_DIR}/examples/meld)
add_test(NAME motion_holes
         COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/hole_motion_test.py
                 $<TARGET_FILE:meldsim> ${CMAKE_SOURCE_DIR}/examples/meld)
set_tests_properties(motion_pivoting motion_holes PROPERTIES TIMEOUT 300 PROCESSORS 2)
# Programs of the amoebot model, each from random shapes.
foreach(program spanning_forest erosion_election boundary_election hexagon_formation line_formation coating energy_sharing)
  add_test(NAME amoebots_${program}
           COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/amoebot_programs_test.py
                   $<TARGET_FILE:meldsim> ${CMAKE_SOURCE_DIR}/examples/meld ${program})
  set_tests_properties(amoebots_${program} PROPERTIES TIMEOUT 300 PROCESSORS 2)
endforeach()
# Figures of papers, made again by the scripts of examples/papers.
foreach(paper luby ghs compression election ensembles healing holes kilobots localization pagerank)
  add_test(NAME papers_${paper} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/papers_test.py $<TARGET_FILE:meldsim> ${paper})
  set_tests_properties(papers_${paper} PROPERTIES TIMEOUT 300 PROCESSORS 2)
endforeach()
add_test(NAME motion_connections COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/connections_test.py $<TARGET_FILE:meldsim>)
set_tests_properties(motion_connections PROPERTIES TIMEOUT 300 PROCESSORS 2)
add_test(NAME motion_loads COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/loads_test.py $<TARGET_FILE:meldsim>)
set_tests_properties(motion_loads PROPERTIES TIMEOUT 300 PROCESSORS 2)
add_test(NAME motion_sensors COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/instruments/sensors_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(motion_sensors PROPERTIES TIMEOUT 300 PROCESSORS 2)
add_test(NAME motion_lights COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/instruments/lights_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(motion_lights PROPERTIES TIMEOUT 300 PROCESSORS 2)
add_test(NAME motion_joints COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/joints_test.py $<TARGET_FILE:meldsim>)
set_tests_properties(motion_joints PROPERTIES TIMEOUT 300 PROCESSORS 2)
add_test(NAME motion_attach COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/attach_test.py $<TARGET_FILE:meldsim>)
set_tests_properties(motion_attach PROPERTIES TIMEOUT 300 PROCESSORS 2)
add_test(NAME motion_bodies COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/bodies_test.py $<TARGET_FILE:meldsim>)
set_tests_properties(motion_bodies PROPERTIES TIMEOUT 300 PROCESSORS 2)
