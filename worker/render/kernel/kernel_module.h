// Kernel modules as files. Each names the build that it belongs to, and those of another build are refused:
// tables of another layout would be read as garbage.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "render/kernel/kernel.h"

namespace tessera::render {

/// The symbol that names the build of a module: text that ends with a zero.
inline constexpr const char* kKernelBuildName = "tessera_kernel_build";

/// Returns the build that this program belongs to: its version, and a digest of all headers that programs and
/// modules share.
const char* kernel_build();

/// Opens the module `file`, which is looked for as dlopen() does, for the rest of the program's life. Returns
/// NotFound with the loader's reason where it cannot be opened, and FailedPrecondition with both builds where
/// it belongs to another one than the program.
absl::StatusOr<const Kernel*> open_kernel_module(const std::string& file);

/// The file of an ISA's module: "libtessera_kernel_avx2.so".
std::string kernel_file(const std::string& isa, KernelLight light);

/// Opens the module of an ISA on first use. The errors are those of open_kernel_module(), and NotFound where
/// this processor lacks the ISA.
absl::StatusOr<const Kernel*> kernel_of(const std::string& isa, KernelLight light);

}  // namespace tessera::render
