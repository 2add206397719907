// Counts of the renderer in messages.
#pragma once

#include "tessera/v1/job.pb.h"
#include "wire/render_counts.h"

namespace tessera::wire {

RenderCounts counts_of(const v1::UnitStats& stats);
void set_counts(const RenderCounts& counts, v1::UnitStats& stats);

}  // namespace tessera::wire
