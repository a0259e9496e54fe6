/* main() of the programs that have none of their own. */
#include "test/support/device.h"

int main(void) {
  return run_with_device();
}
