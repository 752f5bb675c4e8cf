# What `cmake --install` puts under a prefix, which can be moved afterwards: the programs find each other and the compiler
# backend from where they lie. `cpack -G DEB` in the build folder makes a Debian package of the same files.
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

# The libraries are also in meldc; here they are to be read. Examples, documentation and support for editors.
install(DIRECTORY ${CMAKE_SOURCE_DIR}/stdlib/ DESTINATION ${CMAKE_INSTALL_DATADIR}/claymeld/library FILES_MATCHING PATTERN "*.meld")
install(DIRECTORY ${CMAKE_SOURCE_DIR}/examples/meld/ DESTINATION ${CMAKE_INSTALL_DATADIR}/claymeld/examples)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/editors DESTINATION ${CMAKE_INSTALL_DATADIR}/claymeld PATTERN __pycache__ EXCLUDE)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/docs/ DESTINATION share/doc/claymeld PATTERN __pycache__ EXCLUDE)
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
list(JOIN exported "," exported)
set_target_properties(meldsim PROPERTIES ENABLE_EXPORTS ON LINK_LIBRARY_OVERRIDE "WHOLE_ARCHIVE,${exported}")

# The Debian package.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME claymeld)
set(CPACK_PACKAGE_VENDOR "The Claymeld project")
set(CPACK_PACKAGE_CONTACT "The Claymeld project <claymeld@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Compiler and runtime for Meld programs on ensembles of modular robots")
# CPack gives its own variable of this name to source packages once it is included; tests need this one.
set(CLAYMELD_PACKAGE_NAME claymeld_${PROJECT_VERSION})
set(CPACK_PACKAGE_FILE_NAME ${CLAYMELD_PACKAGE_NAME})
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# mpirun starts more processes. Extern functions in C need the C library's headers, the Python package its libraries,
# and extensions a compiler and the libraries that our headers include.
set(CPACK_DEBIAN_PACKAGE_DEPENDS openmpi-bin)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "libc6-dev, ffmpeg, python3-h5py, python3-numpy, python3-pandas")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "python3-matplotlib, python3-networkx, g++, cmake, libfmt-dev, libexpected-dev, libxxhash-dev")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
include(CPack)
