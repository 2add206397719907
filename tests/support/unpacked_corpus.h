// Packed parts of the corpus that lies beside the project.
#pragma once

#include <filesystem>
#include <memory>

#include "support/temp_dir.h"

namespace tessera::test {

/// Scenes of Mitsuba 3's render tests, unpacked; gone with this object.
class UnpackedSuite {
 public:
  /// The folder that holds "common" and "tests".
  std::filesystem::path path() const { return folder_.path() / "mitsuba-suite"; }

 private:
  support::TempDir folder_;
};

/// Null where ../shared/scenes/mitsuba-suite.tar.xz is not there or tar cannot unpack it.
std::unique_ptr<UnpackedSuite> unpack_mitsuba_suite();

}  // namespace tessera::test
