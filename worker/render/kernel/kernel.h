// The seam between code that runs everywhere and the kernels, which are compiled once an ISA into modules of
// their own.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "render/integrator/integrator.h"
#include "render/light/light_table.h"

namespace tessera::render {

struct AccelKernel;
struct QueryKernel;

struct Kernel {
  const char* isa;
  const AccelKernel* accel;
  const QueryKernel* query;
  /// One for each of wire::algorithms().
  std::span<const Algorithm> algorithms;
  LightSources light_sources;
  /// The counter that RenderStats::times are read from, in its own unit.
  std::uint64_t (*clock_ticks)();
  /// How this machine rounds with these kernels (accel/arithmetic.h).
  std::uint32_t (*arithmetic_checksum)();

  /// Also one that was added. Null when there is none with this name.
  const Algorithm* find(std::string_view name) const;
};

/// Adds an algorithm that works with every kernel, at the start of a program, before anything else is called.
/// Its traits are added by wire::add_algorithm.
void add_algorithm(const Algorithm& algorithm);

/// The symbol by which a kernel module gives its kernel.
using KernelEntry = const Kernel* (*)();
inline constexpr const char* kKernelEntryName = "tessera_kernel";

/// The light that kernels carry.
enum class KernelLight : std::uint8_t { kRgb, kWavelengths };

/// The kernel of an ISA, loaded on first use; null when this build or this processor lacks it, or its module
/// belongs to another build.
const Kernel* find_kernel(const std::string& isa, KernelLight light = KernelLight::kRgb);

}  // namespace tessera::render
