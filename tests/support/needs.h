// Why a test is skipped, where that is for want of something that `deploy/setup.sh --ci` installs or that
// lies beside the clone in CI: `.ci/run` fails on such skips.
#pragma once

#include <string>

namespace tessera::test {

/// For GTEST_SKIP(): "needs WHAT".
inline std::string needs(const std::string& what) { return "needs " + what; }

}  // namespace tessera::test
