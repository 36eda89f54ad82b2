# What is linked into the program, each with the Debian package that owns one of its headers: its version,
# its terms and, for the package's Built-Using, its source. The list is held against the build by
# tests/app/cli/licenses_test.cpp.
find_program(DPKG_QUERY dpkg-query REQUIRED)
set(gcc ${CMAKE_CXX_COMPILER_VERSION})
string(REGEX REPLACE "\\..*" "" gcc "${gcc}")
set(LICENSE_TEXTS "")
set(built_using "")
foreach(row "Eigen|eigen3/Eigen/Core" "fmt|fmt/core.h" "CLI11|CLI/CLI.hpp" "JSON for Modern C++|nlohmann/json.hpp"
    "SQLite|sqlite3.h" "libsodium|sodium.h" "libevent|event2/event.h" "Boost|boost/version.hpp"
    "libstdc++|c++/${gcc}/vector")
  string(REGEX MATCH "^([^|]+)\\|(.+)$" matched "${row}")
  set(name "${CMAKE_MATCH_1}")
  set(header "/usr/include/${CMAKE_MATCH_2}")
  execute_process(COMMAND ${DPKG_QUERY} -S ${header} OUTPUT_VARIABLE owner RESULT_VARIABLE failed)
  if(failed)
    message(FATAL_ERROR "no package owns ${header}: the terms of ${name} must be shipped with the program")
  endif()
  string(REGEX REPLACE ":.*" "" package "${owner}")
  execute_process(COMMAND ${DPKG_QUERY} -W -f "\${Version}|\${source:Package} (= \${source:Version})" ${package}
                  OUTPUT_VARIABLE versions)
  string(REGEX MATCH "^([0-9]+:)?([0-9.]+)[^|]*\\|(.+)$" matched "${versions}")
  set(version "${CMAKE_MATCH_2}")
  list(APPEND built_using "${CMAKE_MATCH_3}")
  if(name STREQUAL "libstdc++")
    # Its terms (GPL 3) end where it is linked: that is the GCC Runtime Library Exception.
    set(terms "GPL-3+ with the GCC Runtime Library Exception 3.1, which lets programs that are compiled with
GCC carry it under terms of their own. See /usr/share/doc/${package}/copyright.\n")
  elseif(name STREQUAL "Boost")
    set(terms "Boost Software License 1.0, which asks for no notice in machine-executable object code.
See /usr/share/doc/${package}/copyright.\n")
  else()
    file(READ /usr/share/doc/${package}/copyright terms)
  endif()
  string(APPEND LICENSE_TEXTS "      {\"${name}\", \"${version}\", R\"~~~(${terms})~~~\"},\n")
endforeach()
list(REMOVE_DUPLICATES built_using)
list(JOIN built_using ", " built_using)
file(WRITE ${CMAKE_BINARY_DIR}/built-using "${built_using}\n")
file(READ ${CMAKE_SOURCE_DIR}/LICENSE OWN_TERMS)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/LICENSE)
configure_file(license_texts.cpp.in ${CMAKE_CURRENT_BINARY_DIR}/license_texts.cpp @ONLY)
