// The channels that the AOVs and layers of a job add to its results.
#pragma once

#include <vector>

#include "layers/automaton.h"
#include "tessera/v1/job.pb.h"
#include "wire/aov_list.h"
#include "wire/tile_result.h"

namespace tessera::wire {

/// The channels of every result of a job with these AOVs, in order: R G B A, then what each AOV adds, by its
/// number. In results and images, channels have names; in jobs, AOVs are numbers.
std::vector<ChannelDesc> channels_for_aovs(std::vector<v1::AOV> aovs);
/// The same, and behind them the film's bands, in the order of their wavelengths, and the channels of the
/// layers: three each, in their order.
std::vector<ChannelDesc> channels_of(const v1::JobSpec::View& view);

/// The AOV's row in the list of those of first hits; null where it is another one.
const HitAovRow* find_hit_aov(v1::AOV aov);

/// The layers of a job.
std::vector<layers::Layer> layers_of(const v1::JobSpec::View& view);

/// Whether the AOV is of the camera rays themselves: what they meet first, or visit on their way.
bool is_first_hit(v1::AOV aov);

/// Whether its channels are a list of identifiers (ChannelKind::kEntry), called NAME.id0, NAME.weight0,
/// NAME.id1 ...
bool is_cryptomatte(v1::AOV aov);

}  // namespace tessera::wire
