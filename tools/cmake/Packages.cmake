# Debian packages, one for each install component: cpack -G DEB, in a build with CMAKE_INSTALL_PREFIX=/usr.
# What goes where is said by the install() rules of each room; here are names, texts, dependencies and scripts.
set(packages hapticd hapticd-vdb libhapticclient1 libhapticclient-dev python3-hapticclient hapticctl hapticctl-import haptic-bench)

# Debian wants these two files in each package.
find_program(HAPTICD_GZIP gzip)
set(changelog ${PROJECT_BINARY_DIR}/changelog.gz)
if(HAPTICD_GZIP)
  execute_process(COMMAND ${HAPTICD_GZIP} -9 -n -c ${PROJECT_SOURCE_DIR}/tools/packages/changelog OUTPUT_FILE ${changelog})
endif()
get_cmake_property(components COMPONENTS)
set(CPACK_COMPONENTS_ALL)
foreach(package ${packages})
  if(NOT package IN_LIST components)
    continue()
  endif()
  list(APPEND CPACK_COMPONENTS_ALL ${package})
  install(FILES ${PROJECT_SOURCE_DIR}/tools/packages/copyright DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${package}
          COMPONENT ${package})
  if(HAPTICD_GZIP)
    install(FILES ${changelog} DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/${package} COMPONENT ${package})
  endif()
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME hapticd)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGE_VENDOR "The hapticd authors")
set(CPACK_PACKAGE_CONTACT "The hapticd authors <hapticd@users.noreply.github.com>")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/tools/packages/compress_man.cmake)
set(CPACK_SET_DESTDIR ON)  # for the files of /etc
set(CPACK_INSTALL_PREFIX ${CMAKE_INSTALL_PREFIX})
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ
    WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/libclient)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)

# hapticd_package(COMPONENT SECTION SUMMARY TEXT...): the fields of one package; TEXT lines as Debian writes them.
function(hapticd_package component section summary text)
  string(TOUPPER ${component} key)
  string(STRIP "${text}" text)
  foreach(pair "NAME=${component}" "SECTION=${section}" "SUMMARY=${summary}")
    string(REGEX MATCH "^[A-Z]+" field ${pair})
    string(REGEX REPLACE "^[A-Z]+=" "" value ${pair})
    set(CPACK_DEBIAN_${key}_PACKAGE_${field} ${value} PARENT_SCOPE)
  endforeach()
  set(CPACK_DEBIAN_${key}_DESCRIPTION "${summary}\n${text}" PARENT_SCOPE)
endfunction()

hapticd_package(hapticd misc "haptic device server" [[
hapticd owns the force-feedback devices of a machine and their deadline:
any number of programs describe what should be felt, and one that stalls,
crashes or lies never reaches the hand. It renders meshes, primitives and
local models at 1 to 4 kHz, limits every force, and starts disarmed.
]])
set(CPACK_DEBIAN_HAPTICD_PACKAGE_DEPENDS "systemd | systemd-standalone-sysusers")
set(CPACK_DEBIAN_HAPTICD_PACKAGE_RECOMMENDS hapticd-vdb)
set(CPACK_DEBIAN_HAPTICD_PACKAGE_SUGGESTS hapticctl)
set(control ${PROJECT_SOURCE_DIR}/tools/packages)
set(CPACK_DEBIAN_HAPTICD_PACKAGE_CONTROL_EXTRA ${control}/hapticd/postinst ${control}/hapticd/prerm
    ${control}/hapticd/postrm ${control}/hapticd/conffiles)

hapticd_package(hapticd-vdb misc "OpenVDB files of the haptic device server's volumes" [[
The program by which hapticd keeps the solids that it has built as OpenVDB
files too, for Blender, Houdini and other programs.
]])
set(CPACK_DEBIAN_HAPTICD-VDB_PACKAGE_DEPENDS "hapticd (= ${PROJECT_VERSION})")

hapticd_package(libhapticclient1 libs "client library of the haptic device server" [[
The C library by which programs open devices, read them at full rate, load
meshes and push local models to hapticd.
]])
set(CPACK_DEBIAN_LIBHAPTICCLIENT1_PACKAGE_CONTROL_EXTRA ${control}/libhapticclient1/triggers)

hapticd_package(libhapticclient-dev libdevel "headers of the haptic device server's client library" [[
What programs are built with that touch by way of hapticd: the C headers,
the C++20 headers over them, and the files of pkg-config and CMake.
]])
set(CPACK_DEBIAN_LIBHAPTICCLIENT-DEV_PACKAGE_DEPENDS "libhapticclient1 (= ${PROJECT_VERSION})")

hapticd_package(python3-hapticclient python "Python module of the haptic device server's client library" [[
The client library for Python programs: devices, history as numpy arrays,
scenes and local models, with context managers.
]])
set(CPACK_DEBIAN_PYTHON3-HAPTICCLIENT_PACKAGE_DEPENDS "python3, python3-numpy, libhapticclient1 (>= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_PYTHON3-HAPTICCLIENT_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON3-HAPTICCLIENT_PACKAGE_CONTROL_EXTRA ${control}/python3-hapticclient/postinst
    ${control}/python3-hapticclient/prerm)

hapticd_package(hapticctl utils "command line of the haptic device server" [[
Lists devices, shows state and timing live, loads meshes, arms and disarms,
and tells what a machine lacks for haptics.
]])
set(CPACK_DEBIAN_HAPTICCTL_PACKAGE_DEPENDS "libhapticclient1 (>= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_HAPTICCTL_PACKAGE_RECOMMENDS hapticd)

hapticd_package(hapticctl-import utils "medical images for the haptic device server" [[
Draws the surface of what is dense in a scan (DICOM, NIfTI, NRRD,
MetaImage, OpenVDB, InVesalius) and loads it into hapticd as something to
touch; cuts fragments out of meshes.
]])
set(CPACK_DEBIAN_HAPTICCTL-IMPORT_PACKAGE_DEPENDS "hapticctl (>= ${PROJECT_VERSION})")  # Which it hands options to.

hapticd_package(haptic-bench science "benchmark of haptic rendering" [[
Judges algorithms that render touch, in the box or yours, over models and
trajectories or recorded sessions: errors of force and place, times and
stability. Replays sessions of hapticd and compares the forces bit for bit.
]])
set(CPACK_DEBIAN_HAPTIC-BENCH_PACKAGE_DEPENDS "python3, libhapticclient1 (>= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_HAPTIC-BENCH_PACKAGE_RECOMMENDS "python3-matplotlib, hapticd (= ${PROJECT_VERSION})")

include(CPack)
