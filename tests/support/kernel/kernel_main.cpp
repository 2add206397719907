// main() of test programs that are compiled for one kernel ISA (skip_missing_isa.cpp).
#include <gtest/gtest.h>

#include "support/run_tests.h"

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return tessera::test::run_tests(argc, argv);
}
