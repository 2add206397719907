// main() of test programs; those that are compiled for one kernel ISA have kernel_main.cpp.
#include <gmock/gmock.h>

#include "support/run_tests.h"

int main(int argc, char** argv) {
  testing::InitGoogleMock(&argc, argv);
  return tessera::test::run_tests(argc, argv);
}
