// Exit codes of the program, and their meaning.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace tessera::client {

enum ExitCode : int {
  kDone = 0,
  kUsage = 2,  // an option, a file or a job that there is not
  kBadScene = 3,
  kUnreachable = 4,  // cannot reach the coordinator, or it refuses
  kJobFailed = 5,
  kIncomplete = 6,    // the image lacks samples, or could not be written
  kHoles = 7,         // the image was written, with holes where units were set aside
  kFramesFailed = 8,  // some frames of an animation have no whole image
  kUnwell = 9,        // doctor found something that has to be mended
  kNotDenoised = 10,  // the image was written as it was rendered, for denoising failed
  kInterrupted = 130
};

/// Prints "tessera: message" to stderr and returns `code`.
int report(ExitCode code, const std::string& message);

/// The same for an error of a call to the coordinator. FailedPrecondition is a refusal: the coordinator has
/// no way to do that, or the job is not in the state for it.
int report_farm_error(const absl::Status& status);

}  // namespace tessera::client
