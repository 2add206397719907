// Photometric files: IES LM-63 (1986 to 2019) and EULUMDAT.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "photometry/lamps/luminaire.h"

namespace tessera::photometry {

/// Contents of a file that an IES file names for the tilt of its lamps.
using TiltFiles = std::function<absl::StatusOr<std::string>(const std::string& name)>;

struct LampFileOptions {
  std::string name;                // of the file, for messages
  TiltFiles tilt_files = nullptr;  // null: factors are taken as 1, with a warning
};

/// Reads either kind, which the text tells. InvalidArgument: "NAME:LINE:COLUMN: ...", the first fault.
/// Appends warnings of the same form: what real files have and the standards do not allow, and figures of the
/// file that contradict each other, flux among them.
absl::StatusOr<Luminaire> read_lamp_file(std::string_view bytes, const LampFileOptions& options,
                                         std::vector<std::string>& warnings);

/// Whether the text begins as an IES file does.
bool is_ies(std::string_view bytes);

absl::StatusOr<Luminaire> read_ies(std::string_view bytes, const LampFileOptions& options,
                                   std::vector<std::string>& warnings);
absl::StatusOr<Luminaire> read_eulumdat(std::string_view bytes, const LampFileOptions& options,
                                        std::vector<std::string>& warnings);

/// A file of the standard of a year (1986, 1991, 1995, 2002 or 2019; 0: that of the luminaire, or else 2019).
/// Luminaires of an IES file that are written to the same standard read back equal; the others keep their
/// intensities. Numbers have as many digits as they need. InvalidArgument for tables that are none
/// (fault_of()), and for other years.
absl::StatusOr<std::string> write_ies(const Luminaire& luminaire, int year = 0);

/// Likewise for EULUMDAT. InvalidArgument for A and B planes, too, which it does not have.
absl::StatusOr<std::string> write_eulumdat(const Luminaire& luminaire);

/// Warnings where figures of the file contradict its intensities: flux of lamps, light output ratio, flux
/// below the horizontal.
std::vector<std::string> flux_warnings(const Luminaire& luminaire);

}  // namespace tessera::photometry
