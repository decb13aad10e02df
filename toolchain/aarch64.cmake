# 64-bit Arm, Linux, by Debian's cross compiler; programs run under qemu-aarch64. With CMAKE_SYSROOT,
# against the libraries there (scripts/sysroot); without, against the libc of the cross compiler.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
# Eigen multiplies and adds in one rounding where the compiler says that the machine can. Then no
# sum would be that of x86-64: results are to be the same bit for bit.
set(CMAKE_CXX_FLAGS_INIT "-U__ARM_FEATURE_FMA")
# What is found in the sysroot is the target's, what is not there is not taken from this machine.
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
