# Limberg::suitesparse: CHOLMOD's orders and supernodes, and METIS. Used by the build and by those who link the library.
# As archives, where there are any: the shared library would bring BLAS, LAPACK, Fortran and OpenMP into every start, with a
# thread for each core. They are position independent enough for a program and, with their names kept inside
# (--exclude-libs), for a shared library.
if(NOT TARGET Limberg::suitesparse)
  find_path(CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
  set(limberg_suitesparse_files)
  foreach(limberg_part cholmod amd camd colamd ccolamd suitesparseconfig)
    find_library(LIMBERG_${limberg_part} NAMES lib${limberg_part}.a ${limberg_part} REQUIRED)
    list(APPEND limberg_suitesparse_files ${LIMBERG_${limberg_part}})
  endforeach()
  find_library(METIS_LIBRARY metis REQUIRED)
  add_library(Limberg::suitesparse INTERFACE IMPORTED GLOBAL)
  target_include_directories(Limberg::suitesparse SYSTEM INTERFACE ${CHOLMOD_INCLUDE_DIR})
  target_link_libraries(Limberg::suitesparse INTERFACE ${limberg_suitesparse_files} ${METIS_LIBRARY})
  unset(limberg_suitesparse_files)
  unset(limberg_part)
endif()
