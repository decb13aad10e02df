# Bare metal: a Cortex-M7 with a double-precision FPU, as on Arm's MPS2 board with image AN500, which
# qemu-system-arm emulates. newlib, its file calls by semihosting; start-up and layout are ours.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR cortex-m7)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)  # there is nothing to link a trial program to
string(JOIN " " CMAKE_CXX_FLAGS_INIT
  -mcpu=cortex-m7 -mthumb -mfpu=fpv5-d16 -mfloat-abi=hard
  -fno-exceptions -fno-rtti -fno-threadsafe-statics -ffunction-sections -fdata-sections)
string(JOIN " " CMAKE_EXE_LINKER_FLAGS_INIT
  -nostartfiles --specs=rdimon.specs -Wl,--gc-sections
  -T ${CMAKE_CURRENT_LIST_DIR}/mps2_an500/memory.ld)
# What every program of this target is linked with.
set(PIPEWRIGHT_START_FILE ${CMAKE_CURRENT_LIST_DIR}/mps2_an500/start.cc)
