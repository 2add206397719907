#include "wire/dispersion.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "base/nearest_name.h"
#include "spectra/sensor/sensor_name.h"
#include "wire/scene_numbers.h"

namespace tessera::wire {
namespace {

absl::StatusOr<spectra::Dispersion> formula_of(const v1::Dispersion& dispersion) {
  switch (dispersion.kind_case()) {
    case v1::Dispersion::kGlass: {
      if (auto found = spectra::find_dispersion(dispersion.glass())) return *found;
      const std::vector<std::string> names = spectra::dispersion_names();
      const std::string nearest = base::did_you_mean(dispersion.glass(), names);
      return absl::InvalidArgumentError(absl::StrCat("there is no glass '", dispersion.glass(), "'",
                                                     nearest.empty() ? "." : nearest, " Known are ",
                                                     absl::StrJoin(names, ", ")));
    }
    case v1::Dispersion::kCauchy:
      return spectra::cauchy_dispersion(dispersion.cauchy().a(), dispersion.cauchy().b(),
                                        dispersion.cauchy().c());
    case v1::Dispersion::kAbbe:
      if (!(dispersion.abbe().number() > 0))
        return absl::InvalidArgumentError(
            absl::StrCat("an Abbe number of ", dispersion.abbe().number(), " is not above 0"));
      return spectra::abbe_dispersion(dispersion.abbe().index(), dispersion.abbe().number());
    case v1::Dispersion::KIND_NOT_SET:
      break;
  }
  return absl::InvalidArgumentError("a dispersion without a kind");
}

}  // namespace

absl::StatusOr<spectra::Dispersion> dispersion_of(const v1::Dispersion& dispersion) {
  auto formula = formula_of(dispersion);
  if (!formula.ok()) return formula;
  for (double nm = spectra::kLeastSensorNm; nm <= spectra::kMostSensorNm; ++nm) {
    const auto index = static_cast<float>(formula->eta(nm));
    if (auto s = check_index(index); !s.ok())
      return absl::InvalidArgumentError(absl::StrCat("at ", nm, " nm, ", std::string(s.message())));
  }
  return formula;
}

}  // namespace tessera::wire
