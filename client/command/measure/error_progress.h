// Tells people how sure the figures of `tessera measure` are by now.
#pragma once

#include <iosfwd>
#include <string>

#include "command/report/progress.h"
#include "measure/sampling.h"

namespace tessera::client {

/// "[=====>    ] 33.4M samples  desk: within 2.3 %, 1 % is wanted", without end of line, at most `columns`
/// characters wide. The bar grows as the square of the worst error falls, as which samples are needed.
/// `wanted`: relative; 0: no error is.
std::string format_error_bar(const SamplingProgress& progress, double wanted, int columns);
/// "33.4M samples: desk is within 2.3 %, 1 % is wanted", of a round that is over.
std::string format_error_line(const SamplingProgress& progress, double wanted);

/// On a terminal one line, redrawn in place after each job; elsewhere a line after each round.
class ErrorProgress {
 public:
  ErrorProgress(ProgressMode mode, std::ostream& out, double wanted, int columns = 80)
      : mode_(mode), out_(out), wanted_(wanted), columns_(columns) {}

  void show(const SamplingProgress& progress);
  /// Ends the line of a bar.
  void finish();

 private:
  const ProgressMode mode_;
  std::ostream& out_;
  const double wanted_;
  const int columns_;
  int told_rounds_ = 0;
  bool bar_shown_ = false;
};

}  // namespace tessera::client
