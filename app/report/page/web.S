/* The page's template, style and script as bytes of the program; the script is bundled at build. */
  .section .rodata
  .macro embed name, file
  .global trammel_page_\name
  .global trammel_page_\name\()_end
trammel_page_\name:
  .incbin "\file"
trammel_page_\name\()_end:
  .endm
  embed template, PAGE_HTML
  embed style, PAGE_CSS
  embed script, PAGE_JS
  embed notices, PAGE_NOTICES
  .section .note.GNU-stack, "", %progbits
