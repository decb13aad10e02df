# 64-bit Arm, Linux: Debian's cross compiler and its libc; programs run under qemu-aarch64.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
# Eigen multiplies and adds in one rounding where the compiler says that the machine can. Then no
# sum would be that of x86-64: results are to be the same bit for bit.
set(CMAKE_CXX_FLAGS_INIT "-U__ARM_FEATURE_FMA")
# Neither libraries of the host nor a loader of the target: one program that any kernel runs.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static")
