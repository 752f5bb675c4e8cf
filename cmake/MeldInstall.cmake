# What `cmake --install` puts under a prefix, which can be moved afterwards: the programs find each other and the compiler
# backend from where they lie. `cpack -G DEB` in the build folder makes Debian packages of the same files: claymeld, and claymeld-view with
# what only pictures and the viewer need.
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME claymeld)
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Manual pages and completion, which the programs print from their own tables of options.
set(printed ${CMAKE_BINARY_DIR}/printed)
set(printed_files "")
foreach(program meldc meldsim)
  set(page ${printed}/${program}.1)
  add_custom_command(OUTPUT ${page} COMMAND ${CMAKE_COMMAND} -E make_directory ${printed}
    COMMAND ${program} help --man > ${page} DEPENDS ${program} VERBATIM)
  list(APPEND printed_files ${page})
  foreach(shell bash zsh fish)
    set(script ${printed}/${program}.${shell})
    add_custom_command(OUTPUT ${script} COMMAND ${CMAKE_COMMAND} -E make_directory ${printed}
      COMMAND ${program} completion ${shell} > ${script} DEPENDS ${program} VERBATIM)
    list(APPEND printed_files ${script})
  endforeach()
  install(FILES ${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
  install(FILES ${printed}/${program}.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME ${program})
  install(FILES ${printed}/${program}.zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions RENAME _${program})
  install(FILES ${printed}/${program}.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d RENAME ${program}.fish)
endforeach()
add_custom_target(printed ALL DEPENDS ${printed_files})

set(programs meldc meldsim)
if(TARGET meldc-lsp)
  list(APPEND programs meldc-lsp)
endif()
install(TARGETS ${programs} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS meld_backend_library LIBRARY DESTINATION lib/claymeld)
if(CLAYMELD_VIEWER)
  install(TARGETS meld_view_library LIBRARY DESTINATION lib/claymeld COMPONENT view)
endif()

# The libraries are also in meldc; here they are to be read. Examples, documentation and support for editors.
install(DIRECTORY ${CMAKE_SOURCE_DIR}/stdlib/ DESTINATION ${CMAKE_INSTALL_DATADIR}/claymeld/library FILES_MATCHING PATTERN "*.meld")
install(DIRECTORY ${CMAKE_SOURCE_DIR}/examples/meld/ DESTINATION ${CMAKE_INSTALL_DATADIR}/claymeld/examples)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/editors DESTINATION ${CMAKE_INSTALL_DATADIR}/claymeld PATTERN __pycache__ EXCLUDE
  PATTERN node_modules EXCLUDE PATTERN "*.vsix" EXCLUDE)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/docs/ DESTINATION share/doc/claymeld PATTERN __pycache__ EXCLUDE PATTERN site EXCLUDE)
# The guides as manual pages, if the site has been made.
install(DIRECTORY ${CMAKE_BINARY_DIR}/site/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man7 OPTIONAL FILES_MATCHING PATTERN "*.7")
install(DIRECTORY ${CMAKE_BINARY_DIR}/site/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man5 OPTIONAL FILES_MATCHING PATTERN "*.5")
install(DIRECTORY ${CMAKE_SOURCE_DIR}/python DESTINATION ${CMAKE_INSTALL_DATADIR}/claymeld PATTERN __pycache__ EXCLUDE
  PATTERN "*.egg-info" EXCLUDE PATTERN build EXCLUDE)
install(FILES README.md CHANGELOG.md LICENSE DESTINATION share/doc/claymeld)

# Headers and the CMake package for extensions in C++, which use what meldsim has and so ask it to export it.
foreach(folder runtime physics)
  install(DIRECTORY ${CMAKE_SOURCE_DIR}/${folder} DESTINATION include/claymeld FILES_MATCHING PATTERN "*.h" PATTERN "*.def")
endforeach()
install(DIRECTORY ${CMAKE_SOURCE_DIR}/examples/extensions DESTINATION ${CMAKE_INSTALL_DATADIR}/claymeld)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/examples/exercises DESTINATION ${CMAKE_INSTALL_DATADIR}/claymeld)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/claymeldConfigVersion.cmake COMPATIBILITY ExactVersion)
install(FILES cmake/claymeldConfig.cmake ${CMAKE_BINARY_DIR}/claymeldConfigVersion.cmake DESTINATION lib/cmake/claymeld)
set(exported runtime_base runtime_base_process runtime_base_files runtime_base_terminal runtime_comm_launch runtime_comm_transport
  runtime_engine_tuple runtime_world_lattice runtime_world_shapes runtime_world_file runtime_world_ensemble runtime_world_partition
  runtime_sim_catoms runtime_sim_network runtime_sim_core)
set(exported_libraries "")
foreach(layer ${exported})
  get_target_property(library ${layer} MELD_LIBRARY)
  list(APPEND exported_libraries ${library})
endforeach()
list(REMOVE_DUPLICATES exported_libraries)
list(JOIN exported_libraries "," exported)
set_target_properties(meldsim PROPERTIES ENABLE_EXPORTS ON LINK_LIBRARY_OVERRIDE "WHOLE_ARCHIVE,${exported}")

# The Debian packages.
set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL claymeld)
if(CLAYMELD_VIEWER)
  list(APPEND CPACK_COMPONENTS_ALL view)
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_PACKAGE_NAME claymeld)
set(CPACK_PACKAGE_VENDOR "The Claymeld project")
set(CPACK_PACKAGE_CONTACT "The Claymeld project <claymeld@example.org>")
# CPack gives its own variable of this name to source packages once it is included; tests need this one.
set(CLAYMELD_PACKAGE_NAME claymeld_${PROJECT_VERSION})
set(CPACK_PACKAGE_FILE_NAME ${CLAYMELD_PACKAGE_NAME})
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# mpirun starts more processes. Extern functions in C need the C library's headers, the Python package its libraries,
# and extensions a compiler and the libraries that our headers include.
set(CPACK_COMPONENT_CLAYMELD_DESCRIPTION "Compiler and runtime for Meld programs on ensembles of modular robots
 Compiles rules into a program for every robot, and runs it for millions of them on one machine or many processes.
 Pictures, films and the viewer are in the package claymeld-view.")
set(CPACK_DEBIAN_CLAYMELD_PACKAGE_NAME claymeld)
set(CPACK_DEBIAN_CLAYMELD_FILE_NAME ${CLAYMELD_PACKAGE_NAME}.deb)
set(CPACK_DEBIAN_CLAYMELD_PACKAGE_DEPENDS openmpi-bin)
set(CPACK_DEBIAN_CLAYMELD_PACKAGE_RECOMMENDS "libc6-dev, python3-h5py, python3-numpy, python3-pandas")
set(CPACK_DEBIAN_CLAYMELD_PACKAGE_SUGGESTS
  "claymeld-view, python3-matplotlib, python3-networkx, g++, cmake, libfmt-dev, libexpected-dev, libxxhash-dev")
set(CPACK_COMPONENT_VIEW_DESCRIPTION "Pictures, films and the viewer of Claymeld
 What meldsim shot, movie and view, and plots of meldsim sweep need.")
set(CPACK_DEBIAN_VIEW_PACKAGE_NAME claymeld-view)
set(CPACK_DEBIAN_VIEW_FILE_NAME claymeld-view_${PROJECT_VERSION}.deb)
set(CPACK_DEBIAN_VIEW_PACKAGE_DEPENDS "claymeld (= ${PROJECT_VERSION}), fonts-dejavu-core")
set(CPACK_DEBIAN_VIEW_PACKAGE_RECOMMENDS ffmpeg)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
include(CPack)
