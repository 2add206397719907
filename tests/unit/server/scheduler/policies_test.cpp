// Policies of the scheduler, each alone on a state of a few lines. How they go together is what the simulator
// (tests/scenario) is about.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scheduler/policy/faults.h"
#include "scheduler/policy/lease_book.h"
#include "scheduler/policy/runs.h"
#include "scheduler/policy/trust.h"
#include "scheduler/policy/unit_failures.h"
#include "unit/server/requests.h"

namespace tessera::server {
namespace {

using ::testing::IsEmpty;

class PoliciesTest : public testing::Test {
 protected:
  PoliciesTest() { state_.workers.reserve(8); }  // so that references to them stay

  /// A job of four tiles of `ranges` units each, all open.
  FarmJob& add_job(std::uint32_t ranges) {
    JobRequest request;
    request.id = "job";
    request.plan = std::make_shared<const WorkPlan>(WorkPlan::make(square_spec("scene", 32, ranges)).value());
    auto job = std::make_unique<FarmJob>(state_.jobs_added++, std::move(request));
    job->units.open_until(job->units.count());
    state_.turns.add(job->number, 0, "", 0);
    return *state_.jobs_by_number.emplace(job->number, std::move(job)).first->second;
  }

  FarmWorker& add_worker(const std::string& id, const std::string& host, std::uint32_t threads = 1) {
    state_.total_threads += threads;
    state_.workers_by_identity[host].insert(id);
    WorkerInfo info;
    info.id = id;
    info.host = host;
    info.threads = threads;
    info.supported_isas = info.classes = {"avx2"};
    return state_.workers.emplace(id, FarmWorker{.info = std::move(info)}).first->second;
  }

  /// The lease of one unit that was pending.
  LeaseId lease(LeaseBook& book, FarmJob& job, FarmWorker& worker, std::uint32_t unit) {
    job.units.take(unit);
    book.add(job, worker,
             {.job = job.number,
              .units = {.first = unit},
              .attempt = ++job.attempts,
              .worker = worker.info.id,
              .deadline = Time{1000}});
    return state_.leases.of_unit(job.number, unit).back();
  }

  FarmState state_{SchedulerOptions{}};
};

TEST_F(PoliciesTest, AHostIsDistrustedForItselfOrItsIdentity) {
  const Trust trust(state_);
  add_worker("1", "a");
  EXPECT_TRUE(trust.is_of_one_identity());
  add_worker("2", "b");
  EXPECT_FALSE(trust.is_of_one_identity());
  state_.distrusted["b"] = "wrong pixels";
  EXPECT_EQ(trust.why_distrusted("b"), "wrong pixels");
  EXPECT_TRUE(trust.trusts("a"));
  EXPECT_TRUE(trust.is_of_one_identity()) << "of those that are trusted";
}

TEST_F(PoliciesTest, RunsAreAsLongAsTheyMayTakeAndAsWhatFailedAllows) {
  const Runs runs(state_);
  FarmJob& job = add_job(64);
  const FarmWorker& worker = add_worker("1", "a");
  EXPECT_EQ(runs.run_from(worker, job, 0).count, 1u) << "nobody knows what a unit costs";
  EXPECT_EQ(runs.charge_for(job, {.first = 0}), Runs::kUnknownUnitCostMs);
  job.mean_unit_cost_ms = 10;
  // The first units of a tile are to be there soon: 100 ms.
  EXPECT_EQ(runs.run_from(worker, job, 0).count, 8u);
  EXPECT_EQ(runs.charge_for(job, runs.run_from(worker, job, 0)), 80);
  // 256 units of 10 ms, half of which are 1.28 s; the run begins at range 32 and may have 32.
  EXPECT_EQ(runs.run_from(worker, job, 32 * 4).count, 32u);
  job.shorter_runs[34 * 4] = 2;
  EXPECT_EQ(runs.run_from(worker, job, 32 * 4).count, 2u);
  EXPECT_TRUE(runs.fits_run(job, 34 * 4, 2));
  EXPECT_FALSE(runs.fits_run(job, 34 * 4, 4));
}

TEST_F(PoliciesTest, UnitsWaitAgainWhenTheirLastLeaseIsOver) {
  const Runs runs(state_);
  LeaseBook book(state_, runs);
  FarmJob& job = add_job(1);
  FarmWorker& worker = add_worker("1", "a");
  const LeaseId id = lease(book, job, worker, 2);
  EXPECT_EQ(job.units.state(2), UnitState::kLeased);
  EXPECT_EQ(worker.load_ms, Runs::kUnknownUnitCostMs);
  EXPECT_EQ(job.only_leases.size(), 1u);
  v1::LeaseToken token;
  token.set_unit_index(2);
  token.set_attempt(1);
  EXPECT_EQ(book.find(job, token, "1"), id);
  EXPECT_EQ(book.find(job, token, "2"), std::nullopt) << "another worker's";
  book.drop(id);
  EXPECT_EQ(job.units.state(2), UnitState::kPending);
  EXPECT_EQ(worker.load_ms, 0);
  EXPECT_EQ(job.leases, 0u);
  EXPECT_THAT(job.holders, IsEmpty());
  EXPECT_THAT(job.only_leases, IsEmpty());
}

TEST_F(PoliciesTest, OneHostAloneIsTakenOutOfAJobAndAUnitOfManyIsSetAside) {
  const Trust trust(state_);
  Classes classes(state_, trust);
  const Eligibility eligibility(state_, trust, classes);
  const Runs runs(state_);
  LeaseBook book(state_, runs);
  JobCourse course(state_, book);
  Faults faults(state_, trust, eligibility, book, course);
  FarmJob& job = add_job(1);
  classes.bind(job, "avx2");
  FarmWorker &first = add_worker("1", "a"), &second = add_worker("2", "b"), &third = add_worker("3", "c");
  job.units.finish({.sequence = 1, .units = {.first = 3}});  // otherwise three failures would end the job
  for (const std::uint32_t unit : {0u, 1u, 2u})
    faults.fail(job, lease(book, job, first, unit), {.message = "out of memory"}, Time{5});
  EXPECT_FALSE(eligibility.may_work_on(first, job, Time{6}));
  EXPECT_TRUE(eligibility.may_work_on(first, job, Time{5} + Faults::kFirstBar));
  EXPECT_TRUE(eligibility.may_work_on(second, job, Time{6}));

  EXPECT_TRUE(eligibility.avoids(first, job, 1)) << "others could take it";
  faults.fail(job, lease(book, job, second, 1), {.message = "out of memory"}, Time{7});
  EXPECT_EQ(job.units.state(1), UnitState::kPending);
  faults.fail(job, lease(book, job, third, 1), {.message = "out of memory"}, Time{8});
  EXPECT_EQ(job.units.state(1), UnitState::kSetAside);
  EXPECT_THAT(faults.what_is_missing(job), testing::HasSubstr("unit 1 failed 3 times"));
  faults.reopen(job);
  EXPECT_EQ(job.units.state(1), UnitState::kPending);
  EXPECT_TRUE(eligibility.may_work_on(first, job, Time{9}));
}

TEST(UnitFailures, WhoeverDiedIsBelievedLessThanWhoeverSpeaks) {
  const auto failures = [](std::size_t count, bool lost, bool many_hosts) {
    std::vector<UnitFailure> all;
    for (std::size_t i = 0; i < count; ++i)
      all.push_back({.host = many_hosts ? std::string(i + 1, 'h') : "h", .message = "", .lost = lost});
    return all;
  };
  EXPECT_FALSE(failed_too_often(failures(kMaxFailures - 1, false, true)));
  EXPECT_TRUE(failed_too_often(failures(kMaxFailures, false, false)));
  EXPECT_TRUE(failed_too_often(failures(kMaxFailures, true, true)));
  EXPECT_FALSE(failed_too_often(failures(kMaxLosses - 1, true, false)));
  EXPECT_TRUE(failed_too_often(failures(kMaxLosses, true, false)));
}

}  // namespace
}  // namespace tessera::server
