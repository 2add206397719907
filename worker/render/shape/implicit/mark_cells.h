#pragma once

#include "render/shape/implicit/implicit_record.h"

namespace tessera::render::TESSERA_ISA {

/// Marks the cells of a surface's bounds in which its function may be zero, for searches by enclosure
/// (cell_walk.h): cells are halved as long as an enclosure of the function has a zero in them. Other surfaces
/// are left as they are. `most_work`: instructions that this may take, on sixteen cells each; a tenth of a
/// second where nothing is said.
void mark_cells(ImplicitRecord& surface, std::size_t most_work = std::size_t{1} << 21);

}  // namespace tessera::render::TESSERA_ISA
