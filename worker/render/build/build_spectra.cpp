#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>
#include <thread>

#include "absl/strings/str_cat.h"
#include "render/build/scene_builder.h"

namespace tessera::render {

namespace {

SampledCurve curve_of(const v1::SampledSpectrum& sampled) {
  return {{sampled.wavelengths_nm().begin(), sampled.wavelengths_nm().end()},
          {sampled.values().begin(), sampled.values().end()}};
}

/// On a thread of its own nobody would catch what is thrown.
template <class Work>
absl::Status without_exceptions(const Work& work) {
  try {
    return work();
  } catch (const std::exception& error) {  // out of memory, above all
    return absl::ResourceExhaustedError(error.what());
  }
}

}  // namespace

absl::Status located(const absl::Status& status, const std::string& where) {
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat(where, ": ", status.message()));
}

Rgb emission(const v1::Spectrum& spectrum) {
  switch (spectrum.kind_case()) {
    case v1::Spectrum::kRgb:
      return {spectrum.rgb().r(), spectrum.rgb().g(), spectrum.rgb().b()};
    case v1::Spectrum::kConstant:
      return {spectrum.constant(), spectrum.constant(), spectrum.constant()};
    case v1::Spectrum::kSampled:
      return emission_rgb(curve_of(spectrum.sampled()));
    case v1::Spectrum::kBlackbody:
      return blackbody_rgb(spectrum.blackbody().kelvin());
    case v1::Spectrum::KIND_NOT_SET:
      break;
  }
  return {};
}

Rgb reflectance(const v1::Spectrum& spectrum) {
  if (spectrum.has_sampled()) return reflectance_rgb(curve_of(spectrum.sampled()));
  return emission(spectrum);
}

absl::Status check_spectrum(const v1::Spectrum& spectrum, const char* what) {
  const auto bad = [&](auto... reason) {
    return absl::InvalidArgumentError(absl::StrCat(what, ": ", reason...));
  };
  const v1::SampledSpectrum& sampled = spectrum.sampled();
  if (spectrum.has_sampled()) {
    if (sampled.values().empty() || sampled.values_size() != sampled.wavelengths_nm_size()) {
      return bad("a sampled spectrum needs one value a wavelength, and at least one");
    }
    for (int i = 0; i < sampled.values_size(); ++i) {
      if (!std::isfinite(sampled.values(i)) || !std::isfinite(sampled.wavelengths_nm(i))) {
        return bad("a sampled spectrum holds a number that is not finite");
      }
      if (i > 0 && sampled.wavelengths_nm(i) <= sampled.wavelengths_nm(i - 1)) {
        return bad("the wavelengths of a sampled spectrum must ascend");
      }
    }
    return absl::OkStatus();
  }
  const Rgb rgb = emission(spectrum);
  if (!std::isfinite(rgb.r) || !std::isfinite(rgb.g) || !std::isfinite(rgb.b))
    return bad("a colour is not finite");
  return absl::OkStatus();
}

absl::Status parallel_for(std::size_t n, int threads, const std::function<absl::Status(std::size_t)>& f) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  absl::Status first_error;
  const auto work = [&] {
    for (std::size_t i; (i = next.fetch_add(1)) < n;) {
      const absl::Status status = without_exceptions([&] { return f(i); });
      if (status.ok()) continue;
      std::lock_guard lock(mutex);
      if (first_error.ok()) first_error = status;
      next = n;
    }
  };
  std::vector<std::jthread> workers;
  for (int i = 1; i < threads && static_cast<std::size_t>(i) < n; ++i) workers.emplace_back(work);
  work();
  workers.clear();  // joins
  return first_error;
}

}  // namespace tessera::render
