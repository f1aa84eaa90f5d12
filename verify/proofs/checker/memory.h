/* Linear memory of a proof, byte by byte: no temporary has an address, so a model checker sees numbers only. */
static u8 bytes[MEMORY];

static u64 load(u64 address, u64 size) {
  if (address + size > MEMORY) wasm_rt_trap(WASM_RT_TRAP_OOB);
  u64 value = bytes[address];
  if (size > 1) value |= (u64)bytes[address + 1] << 8;
  if (size > 2) value |= (u64)bytes[address + 2] << 16 | (u64)bytes[address + 3] << 24;
  if (size > 4) {
    value |= (u64)bytes[address + 4] << 32 | (u64)bytes[address + 5] << 40;
    value |= (u64)bytes[address + 6] << 48 | (u64)bytes[address + 7] << 56;
  }
  return value;
}

static void store(u64 address, u64 size, u64 value) {
  if (address + size > MEMORY) wasm_rt_trap(WASM_RT_TRAP_OOB);
  bytes[address] = (u8)value;
  if (size > 1) bytes[address + 1] = (u8)(value >> 8);
  if (size > 2) {
    bytes[address + 2] = (u8)(value >> 16);
    bytes[address + 3] = (u8)(value >> 24);
  }
  if (size > 4) {
    bytes[address + 4] = (u8)(value >> 32);
    bytes[address + 5] = (u8)(value >> 40);
    bytes[address + 6] = (u8)(value >> 48);
    bytes[address + 7] = (u8)(value >> 56);
  }
}

/* What the program begins with. */
static void place(u64 address, const u8 *data, u64 size) {
  for (u64 i = 0; i < size; i++) bytes[address + i] = data[i];
}

#undef LOAD_DATA
#undef DEFINE_LOAD
#undef DEFINE_STORE
#define LOAD_DATA(memory, address, data, size) place(address, data, size)
#define DEFINE_LOAD(name, stored, extended, result) \
  static inline result name(wasm_rt_memory_t *memory, u64 address) { \
    return (result)(extended)(stored)load(address, sizeof(stored)); \
  }
#define DEFINE_STORE(name, stored, given) \
  static inline void name(wasm_rt_memory_t *memory, u64 address, given value) { \
    store(address, sizeof(stored), (u64)value); \
  }
