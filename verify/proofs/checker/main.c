/* Runs a proof in a model checker. PROOF is its function, PROGRAM the file that wasm2c wrote (and COVERS in it the lines
 * to be covered), MEMORY the bytes of its linear
 * memory, its stack at the bottom: below address 0 is out of bounds, too.
 *
 * Without REACH, whatever must not happen is an assertion. With it, such paths end, and two things must be possible: the end
 * of the proof, and every condition that it covers. */
#define WASM_RT_MEMCHECK_SIGNAL_HANDLER 0
#define WASM_RT_USE_STACK_DEPTH_COUNT 0
#define WASM_RT_SKIP_SIGNAL_RECOVERY 1
#include "wasm-rt.h"
#include PROGRAM

#ifdef REACH
#define MUST_NOT_HAPPEN(what)
#else
#define MUST_NOT_HAPPEN(what) __CPROVER_assert(0, what)
#endif

u64 nondet_u64(void);

bool wasm_rt_is_initialized(void) { return true; }

void wasm_rt_allocate_memory(wasm_rt_memory_t *memory, uint32_t pages, uint32_t most) {
  memory->data = bytes;
  memory->pages = pages;
  memory->max_pages = most;
  memory->size = MEMORY;
}

void wasm_rt_trap(wasm_rt_trap_t trap) {
  switch (trap) {
    case WASM_RT_TRAP_OOB: MUST_NOT_HAPPEN("an address out of bounds"); break;
    case WASM_RT_TRAP_INT_OVERFLOW: MUST_NOT_HAPPEN("a quotient that overflows"); break;
    case WASM_RT_TRAP_DIV_BY_ZERO: MUST_NOT_HAPPEN("a division by zero"); break;
    case WASM_RT_TRAP_UNREACHABLE: MUST_NOT_HAPPEN("what was taken for unreachable"); break;
    default: MUST_NOT_HAPPEN("another trap"); break;
  }
  __CPROVER_assume(0);
}

u64 Z_checkerZ_any(struct Z_checker_instance_t *checker) { return nondet_u64(); }

void Z_checkerZ_assume(struct Z_checker_instance_t *checker, u32 condition) { __CPROVER_assume(condition != 0); }

void Z_checkerZ_fail(struct Z_checker_instance_t *checker) {
  MUST_NOT_HAPPEN("a panic");
  __CPROVER_assume(0);
}

void Z_checkerZ_cover(struct Z_checker_instance_t *checker, u32 line, u32 condition) {
#ifdef REACH
#define COVER(wanted) \
  if (line == wanted) { \
    __CPROVER_assert(0, "met " #wanted); \
    __CPROVER_assert(condition == 0, "cover " #wanted); \
  }
  COVERS
#endif
}

int main(void) {
  Z_p_instance_t instance;
  init_globals(&instance);
  init_memories(&instance);
  PROOF(&instance);
#ifdef REACH
  __CPROVER_assert(0, "the end");
#endif
  return 0;
}
