/* Preloaded: counts every request for memory that reaches the C library. */
#include <errno.h>
#include <stdatomic.h>
#include <stddef.h>

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

static atomic_ulong requests;

static void count(void) { atomic_fetch_add_explicit(&requests, 1, memory_order_relaxed); }

unsigned long count_malloc_requests(void) { return atomic_load_explicit(&requests, memory_order_relaxed); }

void *malloc(size_t size) { count(); return __libc_malloc(size); }

void *calloc(size_t items, size_t size) { count(); return __libc_calloc(items, size); }

void *realloc(void *old, size_t size) { count(); return __libc_realloc(old, size); }

void *memalign(size_t alignment, size_t size) { count(); return __libc_memalign(alignment, size); }

void *aligned_alloc(size_t alignment, size_t size) { count(); return __libc_memalign(alignment, size); }

int posix_memalign(void **place, size_t alignment, size_t size) {
    count();
    *place = __libc_memalign(alignment, size);
    return *place || !size ? 0 : ENOMEM;
}
