# Toolchain file: 64-bit ARM from another Debian machine, with the packages of `deploy/setup.sh --arm64`.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(PKG_CONFIG_EXECUTABLE aarch64-linux-gnu-pkg-config)
# CMake runs test programs by this, and so does ctest.
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static)
