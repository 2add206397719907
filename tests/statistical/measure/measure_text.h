// Scenes and meters as texts, measured in this process as `tessera measure` does.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "measure/measured.h"

namespace tessera::test {

struct MeasureRequest {
  std::string scene, meters;  // v1::Scene and v1::MeterList in protobuf's text form
  std::string algorithm = "path";
  bool is_spectral = false;
  std::uint64_t samples = 1 << 14;  // of each figure
  double error = 0;                 // as of --error
  std::uint64_t seed = 1;
  std::vector<std::pair<std::string, std::string>> files = {};  // name and bytes, in the scene's folder
  std::vector<std::string> integrators{};  // that each meter chooses among; empty: all are by `algorithm`
  int threads = 2;
};

absl::StatusOr<client::Measured> measure_text(const MeasureRequest& request);

/// A scene with its meters that is measured several times, but built once.
class MeasuredText {
 public:
  static absl::StatusOr<std::unique_ptr<MeasuredText>> open(const MeasureRequest& request);
  ~MeasuredText();

  /// Measures with `samples` of each figure; the request's own number is not looked at, nor its seed.
  absl::StatusOr<client::Measured> measure(std::uint64_t samples, std::uint64_t seed);

 private:
  struct State;
  explicit MeasuredText(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

/// A scene of a black disk far away, and `more`: there is something to be hit, and to have bounds. Meters
/// are in `medium`.
std::string scene_with(const std::string& more, const std::string& medium = "", double cd_per_m2 = 683);

}  // namespace tessera::test
