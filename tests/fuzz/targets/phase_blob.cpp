// Blobs of phases, as the coordinator checks them: what is accepted is within its bounds, and is written
// again as it was read. The first byte says which phase's.
#include <array>

#include "fuzz/target.h"
#include "wire/noise_pilot_blob.h"
#include "wire/phases/glossy_records.h"
#include "wire/phases/guide_sums.h"
#include "wire/phases/radiosity_links.h"
#include "wire/phases/radiosity_solution.h"

namespace tessera::fuzz {
namespace {

const std::array kChecks = {&wire::kIrradianceRecordsCheck, &wire::kGuideSumsCheck,
                            &wire::kEstimateLinksCheck,     &wire::kPatchLinksCheck,
                            &wire::kRadiositySolutionCheck, &wire::kNoisePilotCheck};

/// The bytes that the readers make of an accepted blob.
std::string written_again(std::string_view blob, const wire::PhaseBlobCheck* check,
                          const wire::PhaseBlob& job) {
  if (check == &wire::kIrradianceRecordsCheck) {
    std::vector<wire::IrradianceRecord> even;
    wire::GlossyRecords glossy;
    glossy.bands = static_cast<int>(job.glossy_bands);
    require(take_records(blob, even) && append_records(blob, glossy), "records that the renderer refuses");
    return blob_of(std::span<const wire::IrradianceRecord>(even)) + blob_of(glossy);
  }
  if (check == &wire::kGuideSumsCheck) {
    std::vector<wire::GuideSum> sums;
    require(wire::append_guide_blob(blob, sums), "sums that the renderer refuses");
    return wire::guide_blob(sums);
  }
  if (check == &wire::kNoisePilotCheck) {
    wire::PilotBlocks pilot;
    require(wire::append_pilot_blob(blob, pilot), "a pilot that the renderer refuses");
    return wire::pilot_blob(pilot);
  }
  if (check == &wire::kRadiositySolutionCheck) return wire::Solution::read(blob).value().blob();
  const std::array<std::string_view, 1> one{blob};
  return wire::merge_links(one).value();
}

bool accepts_phase_blob(std::string_view bytes) {
  if (bytes.empty()) return false;
  const std::size_t kind = static_cast<unsigned char>(bytes.front());
  if (kind >= kChecks.size()) return false;
  const std::vector<char> copy = exact(bytes.substr(1));
  const std::string_view blob{copy.data(), copy.size()};
  const wire::PhaseBlob job{
      .parts = 2, .crop = {0, 0, 64, 32}, .glossy_bands = 3, .memory_limit = std::uint64_t{1} << 20};
  if (kChecks[kind]->fault(blob, job) != nullptr) return false;
  require(blob.size() <= kChecks[kind]->most_bytes(job), "a blob beyond its bound");
  require(written_again(blob, kChecks[kind], job) == blob,
          "a blob that is written otherwise than it was read");
  return true;
}

}  // namespace

const Target kPhaseBlob = {"phase_blob", accepts_phase_blob};

}  // namespace tessera::fuzz
