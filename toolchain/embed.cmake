# pipewright_embed(TARGET FILE SYMBOL): FILE's bytes in TARGET, as
#   namespace pipewright::embedded { std::string_view SYMBOL(); }
# declared in the generated header "embedded/SYMBOL.h". FILE may be of any size and content; the
# text is read when it changes, and the binary needs no file at run time.
function(pipewright_embed target file symbol)
  get_filename_component(path "${file}" ABSOLUTE)
  set(dir "${CMAKE_CURRENT_BINARY_DIR}/embedded_${target}")
  set(header "${dir}/embedded/${symbol}.h")
  set(source "${dir}/embedded/${symbol}.cc")
  add_custom_command(
    OUTPUT "${header}" "${source}"
    COMMAND ${CMAKE_COMMAND} -DFILE=${path} -DSYMBOL=${symbol} -DHEADER=${header}
            -DSOURCE=${source} -P ${PROJECT_SOURCE_DIR}/toolchain/embed_file.cmake
    DEPENDS "${path}" "${PROJECT_SOURCE_DIR}/toolchain/embed_file.cmake"
    VERBATIM)
  target_sources(${target} PRIVATE "${source}" "${header}")
  target_include_directories(${target} PRIVATE "${dir}")
endfunction()
